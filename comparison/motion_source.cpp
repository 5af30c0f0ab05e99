#include "edge_mcl/comparison/compared_filter.h"
#include "edge_mcl/localization/filter/motion_noise.h"

namespace edge_mcl {

Motion MotionSource::next(const LiveInput& input) {
  // MRPT samples the motion with a Cholesky factor, which does not exist for a zero covariance.
  constexpr double kLeast = 1e-6;
  Motion motion;
  motion.sigma.setConstant(kLeast);
  const double dt = last_time_ ? input.time - *last_time_ : 0;
  if (last_time_) {
    if (last_odometry_ && input.odometry) {
      motion.increment = normalized(last_odometry_->inverse() * *input.odometry);
      motion.sigma = odometryNoise(params_, motion.increment, dt).cwiseMax(kLeast);
    } else {
      motion.sigma = walkNoise(params_, dt).cwiseMax(kLeast);
    }
  }
  last_time_ = input.time;
  last_odometry_ = input.odometry;
  return motion;
}

}  // namespace edge_mcl
