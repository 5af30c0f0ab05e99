#include "apps/output_files.h"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/image/picture_file.h"

namespace edge_mcl {

namespace fs = std::filesystem;

std::string textOf(const nlohmann::json& content) {
  return content.dump(1, ' ', false, nlohmann::json::error_handler_t::replace);
}

namespace {

/// Whether the name belongs to a device, a pipe or a directory. A device or a pipe is written to
/// and must not be replaced by a file.
bool isDeviceOrPipe(const std::string& file) {
  std::error_code ignored;
  return fs::exists(file, ignored) && !fs::is_regular_file(file, ignored);
}

}  // namespace

void writeJson(const std::string& file, const nlohmann::json& content) {
  const bool is_device = isDeviceOrPipe(file);
  const std::string partial = is_device ? file : file + ".part";
  std::ofstream out(partial);
  out << textOf(content) << "\n";
  out.close();
  if (!out) throw InputError(file + ": cannot be written");
  if (is_device) return;
  std::error_code problem;
  fs::rename(partial, file, problem);
  if (problem) throw InputError(file + ": cannot be written: " + problem.message());
}

void writeText(const std::string& file, const std::string& text) {
  std::ofstream out(file);
  out << text;
  if (!out.flush()) throw InputError(file + ": cannot be written");
}

void makeDirectory(const std::string& directory) {
  std::error_code problem;
  fs::create_directories(directory, problem);
  if (problem)
    throw InputError(directory + ": the directory cannot be created: " + problem.message());
}

void checkOutput(const std::string& file) {
  if (file.empty()) return;
  std::error_code ignored;
  if (fs::is_directory(file, ignored))
    throw InputError(file + ": cannot be written: it is a directory");
  const bool exists = fs::exists(file, ignored);
  const fs::path inside_folder = fs::path(file).parent_path() / ".";
  if ((exists && access(file.c_str(), W_OK) != 0) ||
      (!isDeviceOrPipe(file) && access(inside_folder.c_str(), W_OK) != 0))
    throw InputError(file + ": cannot be written: " + std::strerror(errno));
}

void checkPicture(const std::string& file) {
  if (file.empty()) return;
  requirePictureName(file);
  checkOutput(file);
}

}  // namespace edge_mcl
