#include "edge_mcl/core/import/importer_process.h"

#include <dlfcn.h>
#include <fcntl.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <memory>
#include <new>
#include <sstream>
#include <system_error>
#include <thread>

#include "edge_mcl/core/base/error.h"

extern char** environ;

namespace edge_mcl {

namespace {

/// Memory of a sanitized program is mostly address space that it never uses.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kLimitMemory = false;
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
constexpr bool kLimitMemory = false;
#else
constexpr bool kLimitMemory = true;
#endif
#else
constexpr bool kLimitMemory = true;
#endif

constexpr int kChildDescriptor = 3;
/// Words before the data of the child.
constexpr char kModelFollows = 'm', kReasonFollows = 'r';

struct FileCloser {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
using OpenFile = std::unique_ptr<std::FILE, FileCloser>;

/// The importer lies in a folder beside the library of this function, in the build tree as after
/// installation.
std::string importerProgram() {
  Dl_info info{};
  if (dladdr(reinterpret_cast<const void*>(&importModel), &info) == 0 || !info.dli_fname)
    throw Error("the folder of the edge_mcl library is not known");
  std::error_code ignored;
  const std::filesystem::path library = std::filesystem::canonical(info.dli_fname, ignored);
  std::string program = (library.parent_path() / "edge_mcl" / "edge_mcl_import").string();
  if (access(program.c_str(), X_OK) != 0)
    throw Error(program + ": the program that imports models is missing; install edge_mcl again");
  return program;
}

/// Starts the importer with `output` as its file descriptor 3.
pid_t startImporter(const std::string& file, uint64_t bytes_of_memory, int output) {
  const std::string program = importerProgram();
  const std::string memory = std::to_string(bytes_of_memory);
  std::array<char*, 4> arguments{const_cast<char*>(program.c_str()),
                                 const_cast<char*>(file.c_str()), const_cast<char*>(memory.c_str()),
                                 nullptr};
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, 0, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, 1, "/dev/null", O_WRONLY, 0);
  // What an importer says about a broken file helps nobody. Its reason comes through the file.
  posix_spawn_file_actions_addopen(&actions, 2, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_adddup2(&actions, output, kChildDescriptor);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t none;
  sigemptyset(&none);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK);
  pid_t child = -1;
  const int fault =
      posix_spawn(&child, program.c_str(), &actions, &attributes, arguments.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&actions);
  if (fault != 0)
    throw Error(program + ": cannot be started: " + std::generic_category().message(fault));
  return child;
}

enum class End { kExited, kKilled, kTooLate };

/// Waits for the end of the child and kills it after `seconds`.
/// @param signal that ended it.
End waitFor(pid_t child, double seconds, int* signal) {
  using Clock = std::chrono::steady_clock;
  const auto deadline = Clock::now() + std::chrono::duration<double>(seconds);
  auto pause = std::chrono::microseconds(500);
  for (;;) {
    int status = 0;
    const pid_t ended = waitpid(child, &status, WNOHANG);
    if (ended == child) {
      if (!WIFSIGNALED(status)) return End::kExited;
      *signal = WTERMSIG(status);
      return End::kKilled;
    }
    // Another part of the program may have collected the child. Its file tells how it ended.
    if (ended < 0 && errno != EINTR) return End::kExited;
    if (Clock::now() > deadline) {
      kill(child, SIGKILL);
      while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
      }
      return End::kTooLate;
    }
    std::this_thread::sleep_for(pause);
    pause = std::min(pause * 2, std::chrono::microseconds(20000));
  }
}

std::string oneLine(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](unsigned char c) { return c < 32; }, ' ');
  return text;
}

std::string numberText(double value) {
  std::ostringstream text;
  text.precision(3);
  text << value;
  return text.str();
}

/// @return the reason of a failure, empty when the model is complete.
std::string readResult(std::FILE* file, RawModel* model) {
  std::rewind(file);
  const int kind = std::fgetc(file);
  if (kind == kReasonFollows) {
    std::string reason(4096, '\0');
    reason.resize(std::fread(reason.data(), 1, reason.size(), file));
    return reason.empty() ? "no reason given" : reason;
  }
  return kind == kModelFollows && readRawModel(file, model) ? "" : "incomplete";
}

}  // namespace

RawModel importModel(const std::string& file, const ImportLimits& limits) {
  std::error_code unknown;
  const uintmax_t size = std::filesystem::file_size(file, unknown);
  const double megabytes = unknown ? 0 : static_cast<double>(size) / 1e6;
  const double seconds = limits.seconds > 0 ? limits.seconds : 20 + 2 * megabytes;
  const double gigabytes = limits.gigabytes > 0 ? limits.gigabytes : 4 + 0.06 * megabytes;
  const int descriptor = memfd_create("edge_mcl_model", MFD_CLOEXEC);
  OpenFile result(descriptor < 0 ? nullptr : fdopen(descriptor, "rb"));
  if (!result) throw Error("no memory file for the import of a model");
  const pid_t child = startImporter(file, static_cast<uint64_t>(gigabytes * 1e9), descriptor);
  int signal = 0;
  const End end = waitFor(child, seconds, &signal);
  if (end == End::kTooLate)
    throw InputError(file + ": the import took more than " + numberText(seconds) +
                     " s and was ended (see map.import_seconds)");
  RawModel model;
  const std::string reason = readResult(result.get(), &model);
  if (reason.empty()) return model;
  if (reason == "memory")
    throw InputError(file + ": the import needs more than " + numberText(gigabytes) +
                     " GB of memory (see map.import_gigabytes)");
  if (end == End::kKilled)
    throw InputError(file + ": the importer crashed on this file (" + strsignal(signal) +
                     "). The file is broken, or it uses a part of its format that the importer "
                     "does not know. Export it as OBJ");
  if (reason == "incomplete") throw InputError(file + ": the importer ended without a result");
  throw InputError(oneLine(reason));
}

void runImporter(const std::string& file, int descriptor, uint64_t bytes_of_memory,
                 const std::function<RawModel(const std::string&)>& read) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);  // nobody waits for the result when the parent has ended
  const rlimit no_core{0, 0};
  setrlimit(RLIMIT_CORE, &no_core);
  const rlimit memory{bytes_of_memory, bytes_of_memory};
  if (kLimitMemory) setrlimit(RLIMIT_AS, &memory);
  std::FILE* output = fdopen(descriptor, "wb");
  if (!output) _exit(1);
  const auto fail = [&](const std::string& reason) {
    std::rewind(output);
    if (ftruncate(descriptor, 0) != 0) _exit(1);
    std::fputc(kReasonFollows, output);
    std::fwrite(reason.data(), 1, reason.size(), output);
    std::fflush(output);
    _exit(1);
  };
  try {
    const RawModel model = read(file);
    std::fputc(kModelFollows, output);
    if (!writeRawModel(model, output)) fail("memory");
  } catch (const std::bad_alloc&) {
    fail("memory");
  } catch (const std::exception& e) {
    fail(e.what());
  }
  _exit(0);  // destructors of a broken scene may crash
}

}  // namespace edge_mcl
