/// Errors of an estimated trajectory in the map frame, without alignment.
#pragma once

#include <string>
#include <vector>

#include "edge_mcl/core/recordings/text_table.h"

namespace edge_mcl {

/// Statistics of one kind of error.
struct ErrorSummary {
  double mean = 0, median = 0, rmse = 0, p90 = 0, max = 0;
};
ErrorSummary summarize(std::vector<double> values);

struct TrajectoryErrors {
  size_t reference_poses = 0, matched = 0;
  std::vector<double> time, position, rotation;  ///< per match: s, m, deg
  ErrorSummary position_summary, rotation_summary;
  /// Relative error between neighbouring matches: what the motion between them is off by.
  ErrorSummary relative_position, relative_rotation;
  double success_share = 0;  ///< of all reference poses: within the limits
  /// The same of the matched ones alone: a reference is often denser than the images.
  double success_share_of_matched = 0;
};

/// Pairs every reference pose with the nearest estimate at most `max_time_difference` apart.
/// @param position_limit m. @param rotation_limit deg.
TrajectoryErrors evaluateTrajectory(const Trajectory& estimate, const Trajectory& reference,
                                    double max_time_difference = 0.005,
                                    double position_limit = 0.10, double rotation_limit = 3.0);

}  // namespace edge_mcl
