#include "edge_mcl/viewer/scene/pose_pick.h"

#include <cmath>

namespace edge_mcl {

PoseGaussian poseFromPick(const ViewMoment& m, const Eigen::Vector3d& pressed,
                          const Eigen::Vector3d& released) {
  constexpr double kHeight = 1.2, kClick = 0.15;  // m
  constexpr double kPosition = 0.5, kAngle = 15 * M_PI / 180;
  PoseGaussian result;
  const Eigen::Vector3d towards = released - pressed;
  Eigen::Matrix3d now = Eigen::Matrix3d::Identity();
  // A base whose z axis is the optical axis is itself an optical frame. Level, it would look at the
  // ceiling.
  constexpr double kSteep = 0.7;
  if (m.has_pose)
    now = m.estimate.mean.linear();
  else if (m.has_camera && m.T_base_camera.linear()(2, 2) > kSteep)
    now = opticalOnBody().linear() * m.T_base_camera.linear().transpose();
  // The heading is the direction of the optical axis over the ground, because the base may have any
  // axes.
  const Eigen::Vector3d view = now * m.T_base_camera.linear().col(2);
  double turn = 0;
  if (towards.head<2>().norm() > kClick)
    turn = std::atan2(towards.y(), towards.x()) - std::atan2(view.y(), view.x());
  result.mean.linear() = Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()) * now;
  result.mean.translation() = pressed + Eigen::Vector3d(0, 0, kHeight);
  result.covariance.diagonal().head<3>().setConstant(kPosition * kPosition);
  result.covariance.diagonal().tail<3>().setConstant(kAngle * kAngle);
  return result;
}

}  // namespace edge_mcl
