/// Asks from time to time whether a pose that looks like the tracked one fits the images better.
#pragma once

#include <optional>
#include <vector>

#include "edge_mcl/localization/filter/look_alikes.h"

namespace edge_mcl {

/// A pose that has moved on by one step of a stair or by one shelf has the right rotation, so poses
/// that are turned do not tell it from the right one. Poses that are a repeat away do.
class LookAlikeWatch {
 public:
  struct Result {
    /// Natural logarithm of P(pose) / P(best look-alike) by this image, at most one that is far
    /// enough away to be wrong. None: not asked, there is none, or it is better for the first time.
    std::optional<double> log_odds;
    /// The same by motion: a look-alike outside the covariance of the prediction needs a jump.
    double by_motion = 0;
    /// The look-alike (T_map_base), when the same one has been better twice in a row.
    std::optional<Pose> better;
  };
  /// @param pose T_map_base @param predicted covariance before the image @param time s
  Result look(const LocalizationMap& map, const std::vector<CameraView>& views, const Pose& pose,
              const Matrix6& predicted, double time);
  /// Starts at a new pose.
  void begin() { *this = {}; }

 private:
  std::optional<double> next_;  // time of the next question, s
  int better_ = 0;              // times in a row that the same look-alike was better
  Eigen::Vector3d offset_ = Eigen::Vector3d::Zero();  // of that look-alike from the pose, m
};

}  // namespace edge_mcl
