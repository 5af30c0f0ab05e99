/// Finds the pose without knowing where to begin, from several images with motion between them.
#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "edge_mcl/localization/search/pose_finder.h"
#include "edge_mcl/localization/search/pose_search.h"

namespace edge_mcl {

/// Hypotheses are poses; each is followed through the keyframes by odometry and refinement, and
/// judged by all of them together. New ones are searched for in the first keyframes and now and
/// then later, and then followed backwards, so that all are judged by the same images.
class GlobalLocalizer : public PoseFinder {
 public:
  /// The map must outlive this object.
  GlobalLocalizer(const LocalizationMap& map, uint64_t seed);

  void begin() override;
  void begin(const PoseGaussian& guess, bool only_there) override;
  void move(const BaseMotion& motion) override;
  /// Takes seconds where the images are a new view.
  SearchReport process(const std::vector<CameraView>& views,
                       const std::optional<UpReading>& up) override {
    return process(views, up, true);
  }
  /// @param look for new hypotheses; otherwise those that there are are followed, which is fast.
  SearchReport process(const std::vector<CameraView>& views, const std::optional<UpReading>& up,
                       bool look);

 private:
  struct Keyframe {
    SearchViews seen;
    BaseMotion since;  ///< the keyframe before
  };
  struct Hypothesis {
    Pose pose = Pose::Identity();   ///< at the newest keyframe
    std::deque<FoundPose> history;  ///< of every keyframe, newest last
    double total = 0;               ///< nats
    int followed = 0;               ///< keyframes since it was found
    PoseGaussian expected;          ///< at the newest keyframe, before its images; if followed
    bool repeated = false;          ///< what looks alike elsewhere in the building has been tried
  };

  static PoseGaussian predicted(const FoundPose& before, const Pose& motion, const Twist& variance);
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
  int keyframe_count_ = 0, look_count_ = 0;
  std::vector<Hypothesis> hypotheses_;  // best first
  std::optional<PoseGaussian> guess_;
  bool only_guess_ = false;
  std::optional<UpReading> up_;
  bool tilt_is_assumed_ = false;
  BaseMotion since_;  // the newest keyframe
  SearchReport report_;
};

}  // namespace edge_mcl
