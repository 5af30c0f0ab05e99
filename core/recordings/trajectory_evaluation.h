/// Errors of an estimated trajectory against a reference, in the map frame, without alignment.
#pragma once

#include <string>
#include <vector>

#include "edge_mcl/core/recordings/text_table.h"

namespace edge_mcl {

/// Statistics of one kind of error. p90 is the 90th percentile.
struct ErrorSummary {
  double mean = 0, median = 0, rmse = 0, p90 = 0, max = 0;
};
/// Statistics of a list of values, all 0 for an empty list. Percentiles are interpolated.
ErrorSummary summarize(std::vector<double> values);

/// Errors of a trajectory. Every matched pair of poses gives one error.
struct TrajectoryErrors {
  /// Number of reference poses, and how many have an estimate.
  size_t reference_poses = 0, matched = 0;
  std::vector<double> time, position, rotation;  ///< per match: seconds, metres, degrees
  ErrorSummary position_summary, rotation_summary;
  /// Error of the motion between neighbouring matches, metres and degrees.
  ErrorSummary relative_position, relative_rotation;
  double success_share = 0;  ///< share of all reference poses with an error within the limits
  /// Share of the matched reference poses with an error within the limits. A reference often has
  /// more poses than there are images.
  double success_share_of_matched = 0;
};

/// Pairs every reference pose with the estimate nearest in time, and compares the pairs.
/// @param max_time_difference s; larger differences give no pair.
/// @param position_limit m.
/// @param rotation_limit deg.
TrajectoryErrors evaluateTrajectory(const Trajectory& estimate, const Trajectory& reference,
                                    double max_time_difference = 0.005,
                                    double position_limit = 0.10, double rotation_limit = 3.0);

}  // namespace edge_mcl
