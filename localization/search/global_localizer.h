/// Finds the pose of a robot that does not know where it is, from several keyframes.
#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <vector>

#include "edge_mcl/localization/search/other_sides.h"
#include "edge_mcl/localization/search/pose_finder.h"
#include "edge_mcl/localization/search/pose_search.h"

namespace edge_mcl {

/// The global search. A hypothesis is a pose. Odometry and refinement follow every hypothesis
/// through the keyframes, and all keyframes together judge it. New hypotheses are searched for in
/// the first keyframes, and in some of the later ones. They are then followed backwards through the
/// earlier keyframes, so that all hypotheses are judged by the same images. Without odometry the
/// hypotheses are followed through images between keyframes as well (a glance). See docs/search.md.
class GlobalLocalizer : public PoseFinder {
 public:
  /// @param map must outlive this object.
  /// @param seed of the random generator.
  GlobalLocalizer(const LocalizationMap& map, uint64_t seed);

  /// false: the search does without prepared places, because they are not there yet.
  void useLookup(bool use) { search_.useLookup(use); }

  void begin() override;
  void begin(const PoseGaussian& guess, bool only_there) override;
  void move(const BaseMotion& motion) override;
  /// Takes seconds when the images become a keyframe.
  SearchReport process(const std::vector<CameraView>& views,
                       const std::optional<UpReading>& up) override {
    return process(views, up, true);
  }
  bool isPrepared() override { return true; }
  /// @param look true: new hypotheses are searched for. false: the existing ones are only followed,
  /// which is fast.
  SearchReport process(const std::vector<CameraView>& views, const std::optional<UpReading>& up,
                       bool look);

 private:
  /// The images of one moment that the search uses.
  struct Keyframe {
    SearchViews seen;
    BaseMotion since;  ///< motion since the keyframe before
  };
  struct Hypothesis {
    Pose pose = Pose::Identity();   ///< T_map_base at the newest keyframe
    std::deque<FoundPose> history;  ///< pose and scores at every keyframe, newest last
    double total = 0;               ///< sum of the log-likelihoods, nats
    int followed = 0;               ///< number of keyframes since it was found
    FoundPose newest;               ///< at the newest keyframe or glance
    PoseGaussian expected;          ///< `newest` as predicted without its images; set when followed
    bool repeated = false;          ///< its look-alikes have been tried
  };

  /// The prior at the next keyframe: the pose moved by odometry. kFollowFloor is added to its
  /// covariance.
  static PoseGaussian predicted(const FoundPose& before, const Pose& motion,
                                const Vector6& variance);
  /// Refines an expected pose. The result pays for what it jumps.
  FoundPose followed(const SearchViews& seen, const PoseGaussian& expected) const;
  /// Moves all hypotheses to images and refines them there.
  void follow(const SearchViews& seen);
  /// Whether most of the best hypotheses have moved as far since the newest keyframe as makes a new
  /// one. It stands in for missing odometry.
  bool haveMoved() const;
  /// Makes a keyframe of images through which all hypotheses were followed.
  void append(SearchViews seen);
  /// The report between keyframes, with the newest pose of the best hypothesis.
  const SearchReport& reportBetween();
  /// Searches for new hypotheses in the newest keyframe.
  void look();
  /// The images of the last keyframes as images of one robot with several cameras.
  std::vector<CameraView> rig() const;
  /// Poses at which new hypotheses may begin, T_map_base.
  std::vector<Pose> candidates();
  /// Whether the newest keyframe is searched everywhere: the number of this search, from 1; 0: no.
  /// @param is_looked_up prepared places have given poses.
  int turnOfEverywhere(bool is_looked_up) const;
  /// Poses along the open directions of the best hypotheses, T_map_base.
  std::vector<Pose> alongWhatWasOpen() const;
  /// Look-alikes of the best hypotheses, T_map_base.
  std::vector<Pose> whereItLooksAlike();
  /// Orientations of the best hypotheses, turned by quarters about the vertical, R_map_base.
  std::vector<Eigen::Matrix3d> rotations() const;
  /// Follows a pose of the newest keyframe backwards through all keyframes.
  Hypothesis backwards(const FoundPose& found) const;
  /// Velocity of a hypothesis in the frame of the base, m/s and rad/s. None with odometry.
  std::optional<Twist> velocityOf(const Hypothesis& h) const;
  /// Follows the best hypotheses backwards again and keeps better scores.
  void smooth();
  /// Sorts the hypotheses, best first.
  void sort();
  /// Merges hypotheses that have come together, and drops bad ones.
  void prune();
  /// How many keyframes of a hypothesis have an image, and how many have depth.
  struct Support {
    int images = 0, depths = 0;
  };
  /// Makes the report of the newest keyframe.
  SearchReport judge() const;
  /// Adds the view that tells the two best places apart, when they are nearly equally likely.
  void addNextView(SearchReport* report) const;
  /// Adds the best places with their probabilities. @return the score of the second place, at least
  /// 0, nats
  double addClusters(SearchReport* report) const;
  /// Adds the means of evidence, match ratio and depth agreement over the keyframes.
  static Support addMeans(const Hypothesis& best, SearchReport* report);
  /// Margin to other places that proves the pose, nats.
  double neededMargin(const SearchReport& report, const Support& support) const;
  /// Whether images and depth fit the best hypothesis well enough.
  bool isExplained(const SearchReport& report, const Support& support) const;
  /// Whether a neighbour explains the images nearly as well as the best hypothesis.
  bool hasRival(double needed_margin) const;

  const LocalizationMap& map_;
  PoseSearch search_;
  OtherSides other_sides_;
  RandomSource random_;
  std::deque<Keyframe> keyframes_;
  int keyframe_count_ = 0, look_count_ = 0;
  std::vector<Hypothesis> hypotheses_;  // best first
  std::optional<PoseGaussian> guess_;   // T_map_base now
  bool only_guess_ = false;
  std::optional<UpReading> up_;   // roll and pitch now
  bool tilt_is_assumed_ = false;  // up_ is from the guess
  BaseMotion since_;              // motion since the newest keyframe
  BaseMotion since_look_;         // motion since the newest keyframe or glance
  SearchReport report_;
};

}  // namespace edge_mcl
