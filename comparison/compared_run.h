/// Runs one filter over one sequence and measures its errors and times.
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
  std::string failure;           ///< message of the exception; empty: the run came to its end
  size_t images = 0;             ///< processed images
  ErrorSummary position, plane;  ///< errors, m; plane: of x and y only
  ErrorSummary rotation;         ///< errors, deg
  double success = 0;  ///< share of the images with ground truth with errors below 10 cm and 3 deg
  bool lost = false;   ///< error of the last image above 25 cm or 5 deg, or the run failed
  ErrorSummary update_ms;                     ///< time from the image in memory to the pose
  double peak_mb = 0;                         ///< largest resident size of the process
  std::vector<double> time, position_series;  ///< of every image: s since the first image; error, m
};

/// Runs a method in this process. Other exceptions than InputError end the run and are stored in
/// `failure`. @param directory of the sequence, which must have ground truth and a model.
/// @throws InputError
ComparedRun runCompared(const std::string& method, const std::string& directory, uint64_t seed,
                        int particles);

nlohmann::json toJson(const ComparedRun& run);
/// Reads a stored run. @param origin named in errors. @throws InputError when a key is missing.
ComparedRun runFromJson(const nlohmann::json& json, const std::string& origin);

}  // namespace edge_mcl
