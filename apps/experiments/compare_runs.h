/// Runs for the comparison: each in a process of its own, each kept in a file.
#pragma once

#include <string>
#include <vector>

#include "edge_mcl/comparison/compared_run.h"

namespace edge_mcl {

/// What one run needs to know.
struct RunRequest {
  std::string method, directory, sequence;
  uint64_t seed = 1;
  int particles = 0;
};

class ComparedRuns {
 public:
  /// @param folder for results; is made. @param core that the runs are bound to.
  ComparedRuns(std::string folder, int core);

  /// Read where it is kept, else run. A process that crashes is a result, too; one that does not
  /// start is none.
  /// @throws InputError when input is missing or broken, or a kept result is; Error when the run
  /// cannot be started.
  ComparedRun get(const RunRequest& request) const;
  bool isKept(const RunRequest& request) const;

 private:
  std::string fileOf(const RunRequest& request) const;
  std::string folder_;
  int core_;
};

/// What the process does: binds itself to the core, runs, writes the result.
void runAndKeep(const RunRequest& request, int core, const std::string& file);

/// Runs this program with other arguments, its output into a file. @return its exit code; 128 and
/// its number for a signal.
int runSelf(const std::vector<std::string>& arguments, const std::string& output_file);

}  // namespace edge_mcl
