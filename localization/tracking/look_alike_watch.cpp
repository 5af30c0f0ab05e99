#include "edge_mcl/localization/tracking/look_alike_watch.h"

#include <algorithm>

#include "edge_mcl/localization/search/pose_tolerances.h"
#include "edge_mcl/localization/tracking/pose_probability.h"

namespace edge_mcl {

namespace {

/// The question takes ten refinements. It is asked this often while no look-alike is near, and for
/// every image while one is.
constexpr double kInterval = 0.4;  // s
/// Nats. In the flight of docs/decisions/tracking-look-alikes.md look-alikes of right poses had an
/// advantage of at most 4, and those of wrong poses up to 124.
constexpr double kNear = -30, kBetter = 8;
/// Samples of one line have correlated errors, so the odds count half.
constexpr double kShare = 0.5;
/// Most that motion says against a look-alike, nats. A pose that lost its way before a bare wall
/// may have a covariance that is too small, so motion must not outweigh an image that tells them
/// apart (kBetter).
constexpr double kMostByMotion = 3;
constexpr int kTwice = 2;
/// Two look-alikes whose offsets from the pose differ by less are the same. In that flight they
/// differ by 2 cm, and those that a cluttered map shows by chance by 20 cm or more.
constexpr double kSameOffset = 0.08;  // m

/// How much less likely motion makes the other pose, nats.
double oddsByMotion(const Pose& pose, Matrix6 covariance, const Pose& other) {
  covariance.diagonal().head<3>().array() += kProofFloor.position * kProofFloor.position;
  covariance.diagonal().tail<3>().array() += kProofFloor.angle * kProofFloor.angle;
  const Twist off = logSe3(pose.inverse() * other);
  return std::min(squaredMahalanobis(off, covariance) / 2, kMostByMotion);
}

}  // namespace

LookAlikeWatch::Result LookAlikeWatch::look(const LocalizationMap& map,
                                            const std::vector<CameraView>& views, const Pose& pose,
                                            const Matrix6& predicted, double time) {
  Result result;
  if (next_ && time < *next_ && time > *next_ - 2 * kInterval) return result;
  const std::optional<LookAlike> other = bestLookAlike(map, views, pose);
  next_ = time + (other && other->advantage > kNear ? 0 : kInterval);
  if (other && other->advantage > kBetter) {
    const Eigen::Vector3d offset = other->pose.translation() - pose.translation();
    better_ = better_ > 0 && (offset - offset_).norm() < kSameOffset ? better_ + 1 : 1;
    offset_ = offset;
  } else {
    better_ = 0;
  }
  if (!other || better_ == 1) return result;  // one image may be a bad one
  if ((other->pose.translation() - pose.translation()).norm() > kRightWithin) {
    result.log_odds = -kShare * other->advantage;
    result.by_motion = oddsByMotion(pose, predicted, other->pose);
  }
  if (better_ >= kTwice) result.better = other->pose;
  return result;
}

}  // namespace edge_mcl
