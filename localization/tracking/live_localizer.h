/// Localizes a robot from moment to moment, and reports in a state how far its pose can be trusted.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "edge_mcl/core/localization_map.h"
#include "edge_mcl/localization/filter/pose_filter.h"
#include "edge_mcl/localization/masks/depth_masker.h"
#include "edge_mcl/localization/masks/mask_lifter.h"
#include "edge_mcl/localization/objects/object_follower.h"
#include "edge_mcl/localization/search/pose_finder.h"
#include "edge_mcl/localization/tracking/calibration_checks.h"
#include "edge_mcl/localization/tracking/localizer_state.h"
#include "edge_mcl/localization/tracking/look_alike_watch.h"
#include "edge_mcl/localization/tracking/odometry_track.h"
#include "edge_mcl/localization/tracking/pose_probability.h"
#include "edge_mcl/localization/tracking/pose_proof.h"
#include "edge_mcl/localization/tracking/stamp_guard.h"
#include "edge_mcl/localization/tracking/surface_agreement.h"

namespace edge_mcl {

/// All sensor data of one moment.
struct LiveInput {
  /// An image of one camera.
  struct CameraImage {
    CameraModel camera;
    cv::Mat image;
    cv::Mat mask;                           ///< empty: none
    Pose T_base_camera = Pose::Identity();  ///< extrinsics
    std::string origin;                     ///< named in errors
  };
  /// A depth image of one sensor.
  struct Depth {
    DepthImage image;
    Pose T_base_camera = Pose::Identity();
    uint32_t sensor = 0;  ///< number of the sensor, see CameraView::depth_sensor
  };
  double time = 0;  ///< seconds
  std::vector<CameraImage> images;
  std::vector<Depth> depths;
  std::string time_text;         ///< stamp as the recording writes it, for output; may be empty
  std::optional<Pose> odometry;  ///< T_odom_base at this moment; none: not known
  std::optional<UpReading> up;   ///< roll and pitch at this moment, from an IMU; none: not known
  bool force_update = false;     ///< the images are used even without motion
};

/// Result for one moment.
struct LiveResult {
  LocalizerState state = LocalizerState::kUninitialized;
  std::string problem;        ///< a fault, in one line; empty: no fault
  bool is_told_once = false;  ///< the problem lasts, but later results do not tell it again
  bool updated = false;       ///< the images were used
  /// The moment was not used because of its time stamp, see StampGuard. The estimate is that of the
  /// moment before.
  bool late = false;
  bool restarted = false;  ///< the clock jumped back; localization or search began again
  PoseGaussian estimate;   ///< T_map_base at this moment
  UpdateReport report;
  StageTimes image_times;
  /// Probability that the pose is within 0.25 m and 5 degrees, see PoseProbability.
  double probability = 0;
  double log_odds = 0;           ///< of this image alone; 0: it told nothing
  OdometryCalibration odometry;  ///< learnt errors of odometry
  double masked_share = 0;       ///< masked share of the image; the largest of all cameras
  double foreign_share = 0;      ///< change of this share by depth; the largest as well
  /// Share of the depth that lies on the model, without what is in front of it; the largest of all
  /// sensors. -1: no mask by depth was tried.
  double foreign_agreement = -1;
  bool depth_agrees = false;         ///< foreign_agreement is enough for masks at a likely pose
  double foreign_ms = 0;             ///< time for masks by depth, ms
  std::vector<ObjectState> objects;  ///< not in the model, known so far; with masks by depth
  double objects_ms = 0;             ///< time for following them, ms
  LookAlikeWatch::Result look_alike;
  double match_ratio = 0;  ///< share of the visible samples with an image edge in reach
  std::vector<std::shared_ptr<const PreparedImage>> images;  ///< those that can be used
  std::vector<size_t> image_numbers;  ///< number of the view of every image in `images`
  /// During a search: places where the robot may be, best first. Empty otherwise.
  std::vector<PoseCluster> clusters;
  std::optional<NextView> next_view;  ///< view that tells the two best of them apart
  int search_keyframes = 0;           ///< number of keyframes that the search has used so far
  double search_ms = 0;               ///< computing time of the search for this keyframe, ms
  bool relocalized = false;  ///< the search has found the pose, and the filter starts there
};

/// Particle filter, search and states together.
class LiveLocalizer {
 public:
  /// @param search_in_background true: the search has a thread of its own, and images are used
  /// during a search. The result then depends on the speed of the machine. false: process() waits
  /// for the search, which takes seconds for a keyframe.
  explicit LiveLocalizer(std::shared_ptr<const LocalizationMap> map,
                         bool search_in_background = false);

  /// Starts at this pose (T_map_base) with the next moment. @throws InputError when it is not
  /// finite
  void setPose(const PoseGaussian& pose);
  /// Forgets the pose and searches for it in the whole model, from the next moment on. There is no
  /// pose until the search finds it.
  void searchEverywhere();
  /// Forgets the pose and searches for it around a guess (T_map_base at the next moment), later in
  /// the whole model. For guesses that are too rough to start particles there.
  void searchAround(const PoseGaussian& guess);
  /// Prepares the places of the map in the search's thread, so that a search begins at once. Only
  /// with a search in the background.
  void prepareSearch();
  /// Starts with these particles (T_map_base), for example stored ones. @throws InputError when
  /// they cannot be used
  void setParticles(std::vector<Pose> poses, std::vector<double> log_weights);
  /// Parameters for the use of images and the trust in poses. They start as those of the map.
  const TrackingParameters& tracking() const { return tracking_; }
  void setTracking(const TrackingParameters& tracking) { tracking_ = tracking; }
  /// Continues in another map. A search that runs begins again.
  void setMap(std::shared_ptr<const LocalizationMap> map);

  /// Whether there is a pose. It need not be trusted.
  bool isInitialized() const { return initial_.has_value(); }
  const LocalizationMap& map() const { return *map_; }
  const PoseFilter& filter() const { return filter_; }
  LocalizerState state() const { return states_.state(); }

  /// The newest pose that was tracked, T_map_base, if it is at most so old at the newest moment.
  /// A pose that was never tracked, or is lost, may be anywhere. @param age s
  std::optional<PoseGaussian> trackedPose(double age) const;

  /// Predicts the particles to the time of the input and uses its images if they can be used. A
  /// fault of the input is reported in the result and not thrown.
  LiveResult process(const LiveInput& input);

 private:
  /// Resets states and proof for a new pose. Starts a search around it when it is uncertain.
  void begin();
  /// Whether an image with such a stamp is not used. Adds the reason to the result.
  bool isUnusable(StampGuard::Verdict verdict, LiveResult* result);
  /// Predicts to the time of the input. @return false when the input is late
  bool advanceTo(const LiveInput& input, LiveResult* result);
  /// Whether odometry has moved far enough for the images to be used.
  bool hasMoved(const LiveInput& input) const;
  void processImages(const LiveInput& input, LiveResult* result);
  std::vector<CameraView> prepare(const LiveInput& input, LiveResult* result, std::string* problem);
  /// Updates the filter. @return a fault; empty: none
  std::string useImages(std::vector<CameraView> views, LiveResult* result);
  /// Where the search begins: the estimate, wider where nothing but images has told the motion.
  PoseGaussian searchGuess() const;
  void makeFinder();
  void forgetPose();
  void beginSearch(bool only_around);
  /// Goes on at a pose that looks like the tracked one. It must be proven.
  void jumpTo(const Pose& pose, LiveResult* result);
  bool isSpreadWide() const;
  /// Whether only the search uses the images: the pose is lost and the particles are spread wide.
  bool isLeftToSearch(const LiveInput& input) const;
  void search(const LiveInput& input, const std::vector<CameraView>& views, LiveResult* result);
  /// Whether several images in a row have confirmed the filter at the pose that the search has
  /// found.
  bool isRepeated(const SearchReport& report) const;
  /// Whether search and filter have found the same pose. The search is then believed before it has
  /// converged.
  bool agreesWith(const SearchReport& report) const;
  /// Adds a result to the proof of the pose. @return whether the pose is trusted
  bool addToProof(double time, LiveResult* result);
  /// The mask of a view, lifted along model lines that the image shows under it.
  cv::Mat maskOf(size_t number, const LiveInput::CameraImage& view);
  /// What the depth images see in front of the model, while the pose is likely.
  std::vector<DepthMasker::Foreign> foreignParts(const LiveInput& input, LiveResult* result,
                                                 std::string* problem);
  /// The mask of a view, lifted, and changed by what depth shows.
  cv::Mat withForeign(size_t number, const LiveInput::CameraImage& view,
                      const std::vector<DepthMasker::Foreign>& foreign, LiveResult* result);
  void learnUnderMasks(const LiveInput& input, bool used);
  /// Follows the objects in front of the model, at poses that are tracked.
  void followObjects(const LiveInput& input, LiveResult* result);
  /// Asks whether the images have distortion and focal length of their calibrations, at poses that
  /// are tracked.
  void checkCalibration(const LiveInput& input, LiveResult* result);
  void prepareImages(const LiveInput& input, LiveResult* result, std::vector<CameraView>* views,
                     std::string* problem);
  std::vector<CameraView> prepareDepths(const LiveInput& input, std::string* problem) const;
  /// Whether all data that were used agree with the pose.
  bool isConfirmed(const LiveResult& result) const;
  void judge(double time, bool trusted, bool used);
  /// Moves all that is known of the pose by odometry, unless the image of the moment is skipped.
  void follow(const LiveInput& input, double dt);
  void predict(const OdometryStep& step);
  /// Moves it without odometry. @param dt s
  void predictBlindly(double dt);
  /// The estimate, moved by the odometry since the last used image.
  PoseGaussian presentPose() const;

  std::shared_ptr<const LocalizationMap> map_;
  TrackingParameters tracking_;
  PoseFilter filter_;
  PoseProof proof_;
  PoseProbability probability_;
  LookAlikeWatch look_alikes_;
  MaskLifter mask_lifter_;
  DepthMasker depth_masker_;
  SurfaceAgreement surface_agreement_;
  // Of the present moment: numbers of depth images, and what they show in front of the model.
  std::vector<std::pair<size_t, ForeignPoints>> foreign_;
  ObjectFollower objects_;
  CalibrationChecks calibration_checks_;
  std::optional<PoseGaussian> initial_;
  std::optional<PoseGaussian> given_;  // last given pose; start after the clock jumped back
  StateMachine states_;
  bool fresh_ = false;                   // no moment since the pose was given
  std::optional<PoseGaussian> tracked_;  // newest pose that was tracked
  double tracked_at_ = 0;                // its time, s
  StampGuard stamps_;
  std::optional<double> last_time_;
  double longest_interval_ = 0;  // longest recent time between moments, s; 0: not known
  bool is_blind_ = false;        // the newest motion was not told by odometry
  OdometryTrack odometry_;
  std::optional<Pose> odometry_of_update_;  // odometry of the last moment whose images were used
  const bool search_in_background_;
  std::unique_ptr<PoseFinder> finder_;  // made at the first search
  bool searching_ = false;
  bool only_around_ = false;  // the search runs around the given pose only
};

}  // namespace edge_mcl
