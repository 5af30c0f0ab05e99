#include "apps/experiments/compare_runs.h"

#include <fcntl.h>
#include <sched.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <fstream>

#include "apps/common_options.h"
#include "apps/output_files.h"
#include "edge_mcl/core/base/error.h"

extern char** environ;

namespace edge_mcl {

namespace fs = std::filesystem;

int runSelf(const std::vector<std::string>& arguments, const std::string& output_file) {
  std::vector<std::string> words{"edge-mcl"};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  argv.reserve(words.size() + 1);
  for (std::string& w : words) argv.push_back(w.data());
  argv.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, output_file.c_str(),
                                   O_WRONLY | O_CREAT | O_TRUNC, 0644);
  pid_t pid = 0;
  const int failed = posix_spawn(&pid, "/proc/self/exe", &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (failed != 0) throw Error("a run cannot be started");
  int status = 0;
  while (waitpid(pid, &status, 0) < 0)
    if (errno != EINTR) throw Error("waiting for the end of a run failed");
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

ComparedRuns::ComparedRuns(std::string folder, int core) : folder_(std::move(folder)), core_(core) {
  makeDirectory(folder_);
}

std::string ComparedRuns::fileOf(const RunRequest& r) const {
  return folder_ + "/" + r.sequence + "-" + r.method + "-" + std::to_string(r.particles) + "-" +
         std::to_string(r.seed) + ".json";
}

bool ComparedRuns::isKept(const RunRequest& request) const { return fs::exists(fileOf(request)); }

ComparedRun ComparedRuns::get(const RunRequest& r) const {
  const std::string file = fileOf(r);
  if (!fs::exists(file)) {
    const int code = runSelf({"--threads", "1", "compare", "--one", r.method, "--sequence",
                              r.directory, "--seed", std::to_string(r.seed), "--particles",
                              std::to_string(r.particles), "--core", std::to_string(core_), file},
                             "/dev/null");
    if (code == kExitInput || code == kExitUsage)
      throw InputError(r.directory + ": " + r.method + " cannot be run on this sequence");
    // Shells and loaders use these codes when a program or one of its libraries cannot be loaded.
    if (code == 126 || code == 127)
      throw Error("a run cannot be started (exit code " + std::to_string(code) +
                  "); was the program replaced during the comparison?");
    if (code > 128 && (code - 128 == SIGINT || code - 128 == SIGTERM))
      throw InputError("interrupted; the same command continues from here");
    if (code != kExitOk) {
      ComparedRun crashed;
      crashed.method = r.method;
      crashed.sequence = r.sequence;
      crashed.seed = r.seed;
      crashed.particles = r.particles;
      crashed.lost = true;
      crashed.failure = code > 128 ? "ended by signal " + std::to_string(code - 128)
                                   : "exit code " + std::to_string(code);
      writeJson(file, toJson(crashed));
    }
  }
  std::ifstream in(file);
  const nlohmann::json json = nlohmann::json::parse(in, nullptr, false);
  if (json.is_discarded())
    throw InputError(file + ": the file is broken; remove it and run the command again");
  return runFromJson(json, file);
}

void runAndKeep(const RunRequest& r, int core, const std::string& file) {
  cpu_set_t cores;
  CPU_ZERO(&cores);
  CPU_SET(static_cast<size_t>(core), &cores);
  if (sched_setaffinity(0, sizeof cores, &cores) != 0)
    throw InputError("core " + std::to_string(core) + " is not available");
  const ComparedRun run = runCompared(r.method, r.directory, r.seed, r.particles);
  writeJson(file, toJson(run));
}

}  // namespace edge_mcl
