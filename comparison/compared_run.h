/// One filter over one sequence, and what came of it.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "edge_mcl/core/recordings/trajectory_evaluation.h"

namespace edge_mcl {

/// Figures of one run.
struct ComparedRun {
  std::string method, sequence;
  uint64_t seed = 1;
  int particles = 0;
  std::string failure;  ///< empty: it ran to the end
  size_t images = 0;
  ErrorSummary position, plane;  ///< m; plane: of x and y only
  ErrorSummary rotation;         ///< deg
  double success = 0;            ///< share of the images with truth: within 10 cm and 3 degrees
  bool lost = false;             ///< the last image off by more than 25 cm or 5 degrees
  ErrorSummary update_ms;        ///< from the image in memory to the pose
  double peak_mb = 0;            ///< resident size of the process
  std::vector<double> time, position_series;  ///< s since the first image; m
};

/// Runs it in this process. Faults of the input are thrown; what a filter throws is in `failure`.
/// @param directory of the sequence, which must have ground truth. @throws InputError
ComparedRun runCompared(const std::string& method, const std::string& directory, uint64_t seed,
                        int particles);

nlohmann::json toJson(const ComparedRun& run);
/// @throws InputError when something is missing.
ComparedRun runFromJson(const nlohmann::json& json, const std::string& origin);

}  // namespace edge_mcl
