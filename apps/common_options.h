/// Options that several subcommands share.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "edge_mcl/core/base/parameters.h"

namespace CLI {
class App;
}

namespace edge_mcl {

/// The options `--params` and `--set`, and one option for each of four often used parameters:
/// `--particles`, `--likelihood`, `--backend`, `--seed`.
class ParameterOptions {
 public:
  /// Adds the options to a subcommand.
  void addTo(CLI::App* command);
  /// Adds an assignment as `--set NAME=VALUE` does.
  void set(const std::string& name, double value);
  /// Reads the parameters. A later source overrides an earlier one: the defaults, the file of
  /// `--params`, `--set`, the four short options. @throws ParameterError for an unknown name or an
  /// illegal value; InputError when the file cannot be read
  Parameters load() const;

 private:
  std::string file_;
  std::vector<std::string> assignments_;
  std::string particles_, likelihood_, backend_, seed_;
};

/// Exit codes of the tool.
enum ExitCode : int {
  kExitOk = 0,     ///< the work is done
  kExitUsage = 2,  ///< options or parameters are wrong
  kExitInput = 3,  ///< a file is missing or broken; nothing was done, or only a part
  /// The work is done, but some images could not be used or are missing, or no pose was found or
  /// matched. Also: the user interrupted a simulation.
  kExitIncomplete = 4,
  kExitInternal = 5  ///< a fault of the program
};

/// Work of the chosen subcommand. It returns an ExitCode.
using Action = std::function<int()>;
/// This function and the following ones each add one subcommand to the app. When the user chooses
/// the subcommand, it stores its work in `action`.
void addLocalize(CLI::App* app, Action* action);
void addInspect(CLI::App* app, Action* action);
void addEvaluate(CLI::App* app, Action* action);
void addBasin(CLI::App* app, Action* action);
void addBag(CLI::App* app, Action* action);
void addRawlog(CLI::App* app, Action* action);
void addDetect(CLI::App* app, Action* action);
void addSimulate(CLI::App* app, Action* action);
void addCompare(CLI::App* app, Action* action);
void addImageTrials(CLI::App* app, Action* action);
void addTrials(CLI::App* app, Action* action);
void addView(CLI::App* app, Action* action);
void addBench(CLI::App* app, Action* action);
void addWhere(CLI::App* app, Action* action);
void addMap(CLI::App* app, Action* action);
void addAudit(CLI::App* app, Action* action);
void addAlign(CLI::App* app, Action* action);
void addParameters(CLI::App* app, Action* action);

}  // namespace edge_mcl
