#include "output_files.h"

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "edge_mcl/core/error.h"

namespace edge_mcl {

void writeJson(const std::string& file, const nlohmann::json& content) {
  std::ofstream out(file);
  out << content.dump(1) << "\n";
  if (!out.flush()) throw InputError(file + ": cannot be written");
}

void makeDirectory(const std::string& directory) {
  std::error_code problem;
  std::filesystem::create_directories(directory, problem);
  if (problem) throw InputError(directory + ": cannot be made: " + problem.message());
}

}  // namespace edge_mcl
