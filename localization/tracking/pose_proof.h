/// Decides when images that fit a pose prove it.
#pragma once

#include <deque>
#include <optional>

#include "edge_mcl/core/base/parameters.h"
#include "edge_mcl/core/base/se3.h"

namespace edge_mcl {

/// Result of comparing one image with the model at the pose.
struct ImageVerdict {
  double time = 0;  ///< s
  /// When it does not confirm the pose: it speaks against the pose, rather than telling little.
  bool contradicts = false;
  bool confirmed = false;   ///< the image was used and fits
  double match_ratio = 1;   ///< share of the visible samples with an image edge in reach
  double lines = 0;         ///< model lines in view; 0: only depth was compared
  bool on_surface = false;  ///< nearly all of a depth image lies on the model
};

/// While a pose is followed, one image that fits is enough. In three cases it may fit by chance,
/// since two lines fit in many places, and more images must fit before the pose is trusted:
/// * Several images before it did not fit.
/// * The pose is not where odometry has moved the trusted poses of the last second. Somebody may
///   have carried the robot.
/// * Few lines are in view, and suddenly fewer of their samples fit.
class PoseProof {
 public:
  explicit PoseProof(const Parameters& params);

  /// Starts with a new pose. @param needed one image that fits does not prove it
  void begin(bool needed);
  /// Asks for proof from now on. @param anywhere the robot may be anywhere in the model, so that
  /// few lines fit in more places
  void require(bool anywhere) {
    needed_ = true;
    anywhere_ = anywhere_ || anywhere;
  }
  /// Asks for proof after a time without images. Images before it do not count.
  void interrupt(bool anywhere) {
    require(anywhere);
    since_.reset();
  }
  bool isNeeded() const { return needed_; }
  /// Number of images in a row that fitted, up to the last one.
  int confirmations() const { return since_ ? images_ : 0; }

  /// Moves the remembered poses. @param step motion by odometry or as the filter expects, T_old_new
  /// @param sigma its standard deviations, m and rad
  void move(const Pose& step, const Vector6& sigma);
  /// Moves them as a velocity predicts. An error of the velocity is about the same in every step,
  /// so over a second it adds up, other than the noise.
  /// @param drift standard deviations of the step by errors of the velocity, m and rad
  void moveByVelocity(const Pose& step, const Vector6& sigma, const Vector6& drift);

  /// Adds an image. @param estimate pose after the image, T_map_base. @return whether the pose is
  /// trusted now
  bool add(const ImageVerdict& image, const PoseGaussian& estimate);

 private:
  struct Anchor {
    double time;        // s
    PoseGaussian pose;  // trusted then, moved since
    /// A column for each axis of the velocity: how far its error has moved the pose.
    Matrix6 drift = Matrix6::Zero();
  };

  bool isFarFrom(const Anchor& anchor, const PoseGaussian& estimate) const;
  bool isElsewhere(const PoseGaussian& estimate) const;
  bool showsLess(const ImageVerdict& image) const;
  void trust(const ImageVerdict& image, const PoseGaussian& estimate);

  const double enough_ratio_;  // a lower match ratio takes more time; 0: there are no images
  bool needed_ = false, anywhere_ = false;
  std::optional<Anchor> expected_;  // the last trusted pose
  std::deque<Anchor> anchors_;      // earlier trusted poses, oldest first
  double usual_ratio_ = 0;          // mean match ratio of the last trusted images
  std::optional<double> since_;     // time from which all images fit, s
  int doubts_ = 0;                  // images in a row that did not fit
  int images_ = 0;                  // images in a row that fitted
  double ratios_ = 0, lines_ = 0;   // sums over those
};

}  // namespace edge_mcl
