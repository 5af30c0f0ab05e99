/// Finds the pose without knowing where to begin, from several images with motion between them.
#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "edge_mcl/mrpt_plugins/pose_search.h"

namespace edge_mcl {

/// A place where the robot may be.
struct PoseCluster {
  Pose pose = Pose::Identity();  ///< T_map_base
  double weight = 0;             ///< of all, sum 1
};

/// What the search knows after an image.
struct SearchReport {
  bool keyframe = false;              ///< the image was a new view, and used
  bool convincing = false;            ///< `estimate` explains the keyframes, and nothing else does
  bool converged = false;             ///< and so it did when new ones came: it is there
  PoseGaussian estimate;              ///< the best hypothesis, T_map_base; without any: identity
  std::vector<PoseCluster> clusters;  ///< best first, at most ten
  double margin = 0;       ///< nats, by which the best explains the keyframes better than the next
  double evidence = 0;     ///< of the best, mean over the keyframes
  double match_ratio = 0;  ///< likewise
  double depth_agreement = 0;  ///< likewise, of the keyframes with depth
  int keyframes = 0;           ///< so far
  int hypotheses = 0;          ///< kept
  double total_ms = 0;         ///< of this image
};

/// Hypotheses are poses; each is followed through the keyframes by odometry and refinement, and
/// judged by all of them together. New ones are searched for in the first keyframes and now and
/// then later, and then followed backwards, so that all are judged by the same images.
class GlobalLocalizer {
 public:
  /// The map must outlive this object.
  GlobalLocalizer(const LocalizationMap& map, uint64_t seed);

  /// Forgets all and begins anew, in the whole model.
  void begin();
  /// The same; also looks around a guess (T_map_base, at the next image), or there only. Its roll
  /// and pitch are taken to hold for the first keyframes if no better are known.
  void begin(const PoseGaussian& guess, bool only_there);

  /// Motion of the base since the last call of this, over dt seconds; nothing: unknown.
  void move(const std::optional<Pose>& increment, double dt);
  /// Uses images. @param up roll and pitch, if known now.
  SearchReport process(const std::vector<CameraView>& views, const std::optional<UpReading>& up);

 private:
  struct Keyframe {
    SearchViews seen;
    Pose motion = Pose::Identity();  ///< from the keyframe before
    Twist variance = Twist::Zero();  ///< of it
  };
  struct Hypothesis {
    Pose pose = Pose::Identity();   ///< at the newest keyframe
    std::deque<FoundPose> history;  ///< of every keyframe, newest last
    double total = 0;               ///< nats
    int followed = 0;               ///< keyframes since it was found
    PoseGaussian expected;          ///< at the newest keyframe, before its images; if followed
    bool repeated = false;          ///< what looks alike elsewhere in the building has been tried
  };

  bool isNewView() const;
  PoseGaussian predicted(const FoundPose& before, const Pose& motion, const Twist& variance) const;
  void follow();
  void look();
  std::vector<CameraView> rig() const;
  std::vector<Pose> candidates();
  std::vector<Pose> alongWhatWasOpen() const;
  std::vector<Pose> whereItLooksAlike();
  std::vector<Eigen::Matrix3d> rotations() const;
  Hypothesis backwards(const FoundPose& found) const;
  void smooth();
  void sort();
  void prune();
  SearchReport judge() const;

  const LocalizationMap& map_;
  PoseSearch search_;
  RandomSource random_;
  std::deque<Keyframe> keyframes_;
  int keyframe_count_ = 0;
  std::vector<Hypothesis> hypotheses_;  // best first
  std::optional<PoseGaussian> guess_;
  bool only_guess_ = false;
  std::optional<UpReading> up_;
  bool tilt_is_assumed_ = false;
  Pose motion_ = Pose::Identity();  // since the newest keyframe
  Twist variance_ = Twist::Zero();
  double elapsed_ = 0;        // s, likewise
  bool has_odometry_ = true;  // likewise, all of it
  SearchReport report_;
};

}  // namespace edge_mcl
