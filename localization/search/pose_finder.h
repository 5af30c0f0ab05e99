/// Looking for the pose of a robot that does not know where it is: what comes in, what comes out.
#pragma once

#include <optional>
#include <vector>

#include "edge_mcl/core/localization_map.h"
#include "edge_mcl/localization/filter/motion_noise.h"
#include "edge_mcl/localization/filter/tilt_correction.h"

namespace edge_mcl {

/// A place where the robot may be.
struct PoseCluster {
  Pose pose = Pose::Identity();  ///< T_map_base
  double weight = 0;             ///< of all, sum 1
};

/// What the search knows after an image.
struct SearchReport {
  bool keyframe = false;              ///< this holds news: a new view has been used
  bool convincing = false;            ///< `estimate` explains the keyframes, and nothing else does
  bool converged = false;             ///< and so it did when new ones came: it is there
  bool stale = false;                 ///< that was some time ago, and who knows where it is now
  PoseGaussian estimate;              ///< the best hypothesis, T_map_base; without any: identity
  std::vector<PoseCluster> clusters;  ///< best first, at most ten
  double margin = 0;       ///< nats, by which the best explains the keyframes better than the next
  double evidence = 0;     ///< of the best, mean over the keyframes
  double match_ratio = 0;  ///< likewise
  double depth_agreement = 0;  ///< likewise, of the keyframes with depth
  int keyframes = 0;           ///< so far
  int hypotheses = 0;          ///< kept
  double total_ms = 0;         ///< of this keyframe
};

/// Motion of the base over a time.
struct BaseMotion {
  Pose step = Pose::Identity();
  Twist variance = Twist::Zero();  ///< of it
  double elapsed = 0;              ///< s
  double blind = 0;                ///< s of them without odometry

  /// @param increment nothing: unknown
  static BaseMotion of(const FilterParameters& p, const std::optional<Pose>& increment, double dt) {
    BaseMotion motion;
    motion.step = increment.value_or(Pose::Identity());
    motion.variance =
        (increment ? odometryNoise(p, motion.step, dt) : walkNoise(p, dt)).cwiseAbs2();
    motion.elapsed = dt;
    motion.blind = increment ? 0 : dt;
    return motion;
  }

  void add(const BaseMotion& later) {
    step = normalized(step * later.step);
    variance += later.variance;
    elapsed += later.elapsed;
    blind += later.blind;
  }

  /// Whether there is something new to see after it.
  bool isNewView(const SearchParameters& p) const {
    constexpr double kDegree = M_PI / 180;
    if (blind > 0) return elapsed >= p.keyframe_period;
    return step.translation().norm() >= p.keyframe_distance ||
           logSo3(step.linear()).norm() >= p.keyframe_angle_deg * kDegree;
  }
};

/// Finds the pose from several images with motion between them.
class PoseFinder {
 public:
  virtual ~PoseFinder() = default;

  /// Forgets all and begins anew, in the whole model.
  virtual void begin() = 0;
  /// The same; also looks around a guess (T_map_base, at the next image), or there only. Its roll
  /// and pitch are taken to hold for the first keyframes if no better are known.
  virtual void begin(const PoseGaussian& guess, bool only_there) = 0;

  /// Motion since the last call of this.
  virtual void move(const BaseMotion& motion) = 0;
  /// Offers images. @param up roll and pitch, if known now. @return poses as of now
  virtual SearchReport process(const std::vector<CameraView>& views,
                               const std::optional<UpReading>& up) = 0;
};

}  // namespace edge_mcl
