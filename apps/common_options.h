/// Options that several subcommands share.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <string>
#include <vector>

#include "edge_mcl/core/base/parameters.h"

namespace edge_mcl {

/// `--params`, `--set`, and short forms of the most used parameters.
class ParameterOptions {
 public:
  void addTo(CLI::App* command);
  /// Defaults, then the file, then --set, then the short forms. @throws ParameterError, InputError
  Parameters load() const;

 private:
  std::string file_;
  std::vector<std::string> assignments_;
  std::string particles_, likelihood_, backend_, seed_;
};

/// Exit codes of the tool.
enum ExitCode : int {
  kExitOk = 0,
  kExitUsage = 2,  ///< wrong options or parameters
  kExitInput = 3,  ///< a file is missing or broken: nothing or only a part was done
  /// Ran to the end, but some images could not be used or are missing, or no pose was found.
  kExitIncomplete = 4,
  kExitInternal = 5
};

/// A subcommand registers itself and stores what to run.
using Action = std::function<int()>;
void addLocalize(CLI::App* app, Action* action);
void addInspect(CLI::App* app, Action* action);
void addEvaluate(CLI::App* app, Action* action);
void addBasin(CLI::App* app, Action* action);
void addBag(CLI::App* app, Action* action);
void addRawlog(CLI::App* app, Action* action);
void addDetect(CLI::App* app, Action* action);
void addSimulate(CLI::App* app, Action* action);
void addCompare(CLI::App* app, Action* action);
void addTrials(CLI::App* app, Action* action);
void addView(CLI::App* app, Action* action);
void addBench(CLI::App* app, Action* action);
void addParameters(CLI::App* app, Action* action);

}  // namespace edge_mcl
