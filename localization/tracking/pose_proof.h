/// When images that fit a pose are proof of it.
#pragma once

#include <deque>
#include <optional>

#include "edge_mcl/core/base/parameters.h"
#include "edge_mcl/core/base/se3.h"

namespace edge_mcl {

/// What an image said of the pose.
struct ImageVerdict {
  double time = 0;         ///< s
  bool used = false;       ///< it was compared with the model
  bool confirmed = false;  ///< and it fits
  double match_ratio = 1;  ///< share of the visible samples with an image edge in reach
  double lines = 0;        ///< of the model in view; 0: judged by depth alone
};

/// One image that fits is enough while a pose is followed. It is chance after several images that
/// did not fit, or when the pose that it fits is not where odometry has brought the trusted ones of
/// the last second: somebody may have carried the robot, and two lines fit in many places. So it is
/// when suddenly less is seen of the few lines in view.
class PoseProof {
 public:
  explicit PoseProof(const Parameters& params);

  /// A new pose. @param needed one image that fits does not prove it.
  void begin(bool needed);
  /// One image does not prove it any more. @param anywhere the robot may be anywhere in the model:
  /// where few lines are in view, there are many places where they fit.
  void require(bool anywhere) {
    needed_ = true;
    anywhere_ = anywhere_ || anywhere;
  }
  /// A time without any image: what fitted before it says little of what fits now.
  void interrupt(bool anywhere) {
    require(anywhere);
    since_.reset();
  }
  bool isNeeded() const { return needed_; }
  /// Images in a row that fitted, up to the last one.
  int confirmations() const { return since_ ? images_ : 0; }

  /// The robot has moved, by odometry or as the filter expects; sigma: standard deviations.
  void move(const Pose& step, const Twist& sigma);

  /// @param estimate after the image. @return whether it may be trusted now
  bool weigh(const ImageVerdict& image, const PoseGaussian& estimate);

 private:
  struct Anchor {
    double time;        // s
    PoseGaussian pose;  // trusted then, moved by odometry since
  };

  bool isFarFrom(const PoseGaussian& expected, const PoseGaussian& estimate) const;
  bool isElsewhere(const PoseGaussian& estimate) const;
  bool showsLess(const ImageVerdict& image) const;
  void trust(const ImageVerdict& image, const PoseGaussian& estimate);

  const double enough_ratio_;  // match ratio that needs no more time; 0: there are no images
  bool needed_ = false, anywhere_ = false;
  std::optional<PoseGaussian> expected_;  // the last one that was trusted, moved by odometry
  std::deque<Anchor> anchors_;            // those before it, oldest first
  double usual_ratio_ = 0;                // mean match ratio of the last trusted images
  std::optional<double> since_;           // without a gap all images fit
  int doubts_ = 0;                        // images in a row that did not
  int images_ = 0;                        // that did
  double ratios_ = 0, lines_ = 0;         // sums over them
};

}  // namespace edge_mcl
