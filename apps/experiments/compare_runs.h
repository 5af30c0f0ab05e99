/// Makes the runs of a comparison. Each run has its own process, and its result is kept in a file.
#pragma once

#include <string>
#include <vector>

#include "edge_mcl/comparison/compared_run.h"

namespace edge_mcl {

/// Describes one run.
struct RunRequest {
  std::string method, directory, sequence;  ///< name of the method, directory, name of the sequence
  uint64_t seed = 1;
  int particles = 0;
};

/// The runs of a comparison and their results.
class ComparedRuns {
 public:
  /// @param folder for the results; it is created if it does not exist.
  /// @param core number of the processor core that the runs are bound to.
  ComparedRuns(std::string folder, int core);

  /// Reads the result of a run if it is kept, and makes the run otherwise. The crash of a process
  /// is a result, too, and is kept. A process that does not start has no result. @throws InputError
  /// when the input of the run or a kept result is missing or broken, or when the run was
  /// interrupted; Error when the run cannot be started
  ComparedRun get(const RunRequest& request) const;
  /// Whether the result of a run is kept.
  bool isKept(const RunRequest& request) const;

 private:
  std::string fileOf(const RunRequest& request) const;
  std::string folder_;
  int core_;
};

/// The work of the process of a run: binds itself to the core, runs, writes the result to `file`.
void runAndKeep(const RunRequest& request, int core, const std::string& file);

/// Runs this program with other arguments and writes its output to a file.
/// @return its exit code, or 128 plus the number of the signal that ended it.
/// @throws Error when it cannot be started
int runSelf(const std::vector<std::string>& arguments, const std::string& output_file);

}  // namespace edge_mcl
