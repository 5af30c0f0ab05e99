#include "edge_mcl/localization/tracking/look_alike_watch.h"

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
constexpr int kTwice = 2;

}  // namespace

LookAlikeWatch::Result LookAlikeWatch::look(const LocalizationMap& map,
                                            const std::vector<CameraView>& views, const Pose& pose,
                                            double time) {
  Result result;
  if (next_ && time < *next_ && time > *next_ - 2 * kInterval) return result;
  const std::optional<LookAlike> other = bestLookAlike(map, views, pose);
  next_ = time + (other && other->advantage > kNear ? 0 : kInterval);
  better_ = other && other->advantage > kBetter ? better_ + 1 : 0;
  if (!other || better_ == 1) return result;  // one image may be a bad one
  if ((other->pose.translation() - pose.translation()).norm() > kRightWithin)
    result.log_odds = -kShare * other->advantage;
  if (better_ >= kTwice) result.better = other->pose;
  return result;
}

}  // namespace edge_mcl
