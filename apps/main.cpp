// edge-mcl: localization of a camera in a 3D model, from the command line.
#include <tbb/global_control.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <opencv2/core.hpp>
#include <opencv2/core/utils/logger.hpp>
#include <sstream>

#include "apps/common_options.h"
#include "apps/library_messages.h"
#include "edge_mcl/core/base/error.h"

int main(int argc, char** argv) {
  using namespace edge_mcl;
  const LibraryMessages library_messages;
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
  CLI::App app{
      "Finds the 6-DoF pose of a camera inside a known 3D model by Monte-Carlo localization on "
      "edges.\n\nTypical first steps:\n"
      "  edge-mcl inspect model.obj --picture model.png   check how the model is read\n"
      "  edge-mcl localize SEQUENCE --out est.txt         compute the trajectory from the images\n"
      "  edge-mcl view SEQUENCE                           watch the localization\n"
      "  edge-mcl evaluate est.txt groundtruth.txt        compute the errors of the trajectory\n\n"
      "Exit codes: 0: done; 2: wrong options or parameters; 3: a file is missing or broken; 4: "
      "done, but some images could not be used or are missing, no pose was found or matched, or "
      "the command was interrupted; 5: internal error."};
  app.require_subcommand(1);
  app.set_version_flag("--version", EDGE_MCL_VERSION);
  int threads = 0;
  app.add_option("--threads", threads,
                 "number of CPU threads; 0 (default): all cores; results do not depend on it")
      ->check(CLI::Range(0, 1024));
  app.fallthrough();
  Action action;
  addLocalize(&app, &action);
  addInspect(&app, &action);
  addWhere(&app, &action);
  addMap(&app, &action);
  addAudit(&app, &action);
  addAlign(&app, &action);
  addEvaluate(&app, &action);
  addBasin(&app, &action);
  addBag(&app, &action);
  addRawlog(&app, &action);
  addDetect(&app, &action);
  addSimulate(&app, &action);
  addTrials(&app, &action);
  addImageTrials(&app, &action);
  addCompare(&app, &action);
  addView(&app, &action);
  addBench(&app, &action);
  addParameters(&app, &action);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    std::ostringstream out, err;
    const int status = app.exit(e, out, err);
    std::fputs(out.str().c_str(), stdout);
    std::fputs(err.str().c_str(), stderr);
    return status == 0 ? kExitOk : kExitUsage;
  }
  std::unique_ptr<tbb::global_control> limit;
  if (threads > 0)
    limit = std::make_unique<tbb::global_control>(tbb::global_control::max_allowed_parallelism,
                                                  static_cast<size_t>(threads));
  cv::setNumThreads(threads > 0 ? threads : -1);
  try {
    const int status = action();
    // What a full disk or a closed pipe has swallowed must not look like success.
    if (std::fflush(stdout) != 0 || std::ferror(stdout) != 0)
      throw InputError("the result cannot be written to the standard output");
    return status;
  } catch (const ParameterError& e) {
    std::fprintf(stderr, "edge-mcl: %s\n", e.what());
    return kExitUsage;
  } catch (const InputError& e) {
    std::fprintf(stderr, "edge-mcl: %s\n", e.what());
    return kExitInput;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "edge-mcl: internal error: %s\n%s", e.what(),
                 library_messages.text().c_str());
    return kExitInternal;
  }
}
