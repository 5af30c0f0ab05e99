/// Interface of the global search: finds the pose of a robot that does not know where it is.
#pragma once

#include <optional>
#include <vector>

#include "edge_mcl/core/base/angles.h"
#include "edge_mcl/core/localization_map.h"
#include "edge_mcl/localization/filter/motion_noise.h"
#include "edge_mcl/localization/filter/tilt_correction.h"
#include "edge_mcl/localization/search/next_view.h"

namespace edge_mcl {

/// A place where the robot may be.
struct PoseCluster {
  Pose pose = Pose::Identity();  ///< T_map_base
  /// That the robot is within kSamePlace of it, see placeProbabilities(). The rest to the sum 1 is
  /// the probability that all places are wrong.
  double probability = 0;
  double score = 0;  ///< log-likelihood over the keyframes, nats
};

/// State of the search after an image. Poses are T_map_base.
struct SearchReport {
  bool keyframe = false;    ///< true: this report has a new result, because a keyframe was used
  bool convincing = false;  ///< `estimate` explains the keyframes, and no other place does
  bool converged = false;   ///< convincing, with two keyframes since the pose was found
  /// Odometry has carried the pose too far, since the result or between two of its keyframes. The
  /// pose then needs further proof.
  bool stale = false;
  PoseGaussian estimate;  ///< best hypothesis, at this image; identity if there is none
  /// Velocity of the best hypothesis in the frame of the base at the newest keyframe, m/s and
  /// rad/s. Only without odometry.
  std::optional<Twist> velocity;
  std::vector<PoseCluster> clusters;  ///< different places, best first, at most ten
  /// The view that tells the two best places apart. None when one place is much more likely, or
  /// when no view tells them apart.
  std::optional<NextView> next_view;
  /// Log-likelihood of the best hypothesis over the keyframes minus that of the next place, nats.
  /// The next place counts as 0 (no evidence) if it scores less.
  double margin = 0;
  double evidence = 0;         ///< of the best hypothesis, mean over keyframes, see FoundPose
  double match_ratio = 0;      ///< of the best hypothesis, mean over keyframes, see FoundPose
  double depth_agreement = 0;  ///< of the best hypothesis, mean over keyframes with depth
  int keyframes = 0;           ///< number of keyframes so far
  int hypotheses = 0;          ///< number of hypotheses that are kept
  double total_ms = 0;         ///< computing time of this keyframe, ms; 0 without a new result
};

/// Motion of the base over a time, with its uncertainty.
struct BaseMotion {
  Pose step = Pose::Identity();        ///< motion in the frame of the base before it
  Vector6 variance = Vector6::Zero();  ///< of the step, per axis: m^2, rad^2
  double elapsed = 0;                  ///< duration, s
  double blind = 0;                    ///< the part of the duration without odometry, s

  /// Motion over one time step. @param increment from odometry; none: the base is assumed to stand
  /// still, with the noise of the constant-velocity model. @param dt seconds.
  static BaseMotion of(const FilterParameters& p, const std::optional<Pose>& increment, double dt) {
    BaseMotion motion;
    motion.step = increment.value_or(Pose::Identity());
    motion.variance =
        (increment ? odometryNoise(p, motion.step, dt) : walkNoise(p, dt)).cwiseAbs2();
    motion.elapsed = dt;
    motion.blind = increment ? 0 : dt;
    return motion;
  }

  /// Appends a later motion to this one.
  void add(const BaseMotion& later) {
    step = normalized(step * later.step);
    variance += later.variance;
    elapsed += later.elapsed;
    blind += later.blind;
  }

  /// Whether an image after this motion becomes a keyframe: after search.keyframe_distance or
  /// search.keyframe_angle_deg, or, if odometry was missing, after search.keyframe_period.
  /// @param at_rest_too as without odometry: time counts also where odometry tells no motion.
  bool isKeyframe(const SearchParameters& p, bool at_rest_too = false) const {
    if (at_rest_too && elapsed >= p.keyframe_period) return true;
    if (blind > 0) return elapsed >= p.keyframe_period;
    return step.translation().norm() >= p.keyframe_distance ||
           logSo3(step.linear()).norm() >= p.keyframe_angle_deg * kDegree;
  }

  /// Whether hypotheses are followed through an image after this motion, although it may be no
  /// keyframe: after search.glance_period without odometry.
  bool isGlance(const SearchParameters& p) const { return blind > 0 && elapsed >= p.glance_period; }
};

/// Finds the pose from several images with motion between them.
class PoseFinder {
 public:
  virtual ~PoseFinder() = default;

  /// Forgets everything and begins a search in the whole model.
  virtual void begin() = 0;
  /// Forgets everything and begins a search around a guess.
  /// @param guess T_map_base at the next image. Its roll and pitch, if certain enough, are used for
  /// the first keyframes until better ones are known.
  /// @param only_there false: the whole model is searched as well.
  virtual void begin(const PoseGaussian& guess, bool only_there) = 0;

  /// Adds the motion of the base since the last call of move().
  virtual void move(const BaseMotion& motion) = 0;
  /// Offers the images of one moment. They are used if they make a keyframe.
  /// @param up roll and pitch at this moment, if known.
  /// @return state of the search. Odometry carries its estimate to this moment.
  virtual SearchReport process(const std::vector<CameraView>& views,
                               const std::optional<UpReading>& up) = 0;
  /// Whether a search of the whole model can begin at once.
  virtual bool isPrepared() = 0;
};

}  // namespace edge_mcl
