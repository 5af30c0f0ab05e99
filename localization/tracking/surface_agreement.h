/// How much of the depth images lies on the model, as a figure for the probability of a pose.
#pragma once

#include <optional>

#include "edge_mcl/core/base/se3.h"
#include "edge_mcl/core/depth/foreign_points.h"

namespace edge_mcl {

/// Follows the share of the depth that lies on the model, without what is in front of it. A right
/// pose has nearly 1, and so has every pose before a bare wall.
class SurfaceAgreement {
 public:
  /// Starts a moment. @param time s. @param predicted pose before the image, with its covariance. A
  /// pose that is known badly agrees with much, so then there is no share.
  void begin(double time, const PoseGaussian& predicted);
  /// Adds a depth image of the moment.
  void add(const ForeignPoints& found);
  /// The share over all depth images of the moment. A depth camera may be slower than the camera,
  /// so a moment without depth has the share of the one before it. none: there is little depth, or
  /// the pose was known too badly.
  std::optional<double> value() const;
  /// The pose is another one now.
  void forget() { *this = {}; }

 private:
  std::optional<double> ofMoment() const;

  double time_ = 0;         // of the moment, s
  bool is_narrow_ = false;  // the pose of the moment is known well
  bool has_depth_ = false;
  double pixels_ = 0, on_model_ = 0;  // pixels that are not in front, and of these on the model
  double compared_ = 0;               // pixels that have a depth, and a surface behind them
  std::optional<double> last_;        // share of the last moment with depth
  double last_time_ = 0;
};

}  // namespace edge_mcl
