/// Follows a robot from images as they come, and says how far its pose is to be trusted.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "edge_mcl/core/localization_map.h"
#include "edge_mcl/localization/filter/pose_filter.h"
#include "edge_mcl/localization/search/pose_finder.h"
#include "edge_mcl/localization/tracking/localizer_state.h"
#include "edge_mcl/localization/tracking/mask_lifter.h"
#include "edge_mcl/localization/tracking/pose_proof.h"

namespace edge_mcl {

/// What arrived for one moment.
struct LiveInput {
  struct View {
    CameraModel camera;
    cv::Mat image;
    cv::Mat mask;  ///< empty: none
    Pose T_base_camera = Pose::Identity();
    std::string origin;  ///< named in errors
  };
  struct Depth {
    DepthImage image;
    Pose T_base_camera = Pose::Identity();
    uint32_t sensor = 0;  ///< see CameraView::depth_sensor
  };
  double time = 0;  ///< seconds
  std::vector<View> views;
  std::vector<Depth> depths;
  std::optional<Pose> odometry;  ///< T_odom_base at that time
  std::optional<UpReading> up;   ///< roll and pitch at that time, by an IMU
  bool force_update = false;     ///< use the images even without motion
};

/// What was made of it.
struct LiveResult {
  LocalizerState state = LocalizerState::kUninitialized;
  std::string problem;     ///< one line; empty: none
  bool updated = false;    ///< the images were used
  bool late = false;       ///< older than what was seen before; nothing was done
  bool restarted = false;  ///< the clock jumped back: began again at the given pose, or to search
  PoseGaussian estimate;   ///< T_map_base at the input's time
  UpdateReport report;
  StageTimes image_times;
  double masked_share = 0;  ///< largest of the views
  double match_ratio = 0;
  std::vector<std::shared_ptr<const PreparedImage>> images;  ///< empty where not prepared
  std::vector<size_t> image_numbers;  ///< which of the input's views each of `images` is
  /// While the pose is looked for: where it may be, best first. Empty otherwise.
  std::vector<PoseCluster> clusters;
  int search_keyframes = 0;  ///< views that the search has used so far
  double search_ms = 0;
  bool relocalized = false;  ///< the search has found the pose; tracking begins there
};

class LiveLocalizer {
 public:
  /// @param search_in_background images go on being used while the pose is looked for; then what
  /// is found, and when, depends on the speed of the machine. Otherwise process() takes seconds for
  /// some of them.
  explicit LiveLocalizer(std::shared_ptr<const LocalizationMap> map,
                         bool search_in_background = false);

  /// Begins here, T_map_base, with the next image. @throws InputError when it is not finite.
  void setPose(const PoseGaussian& pose);
  /// Looks for the pose in the whole model from the next image on. Until it is found there is none.
  void searchEverywhere();
  /// Takes over particles, e.g. stored ones. @throws InputError
  void setParticles(std::vector<Pose> poses, std::vector<double> log_weights);
  /// When images are used and poses trusted from now on (else as the map's parameters say).
  const TrackingParameters& tracking() const { return tracking_; }
  void setTracking(const TrackingParameters& tracking) { tracking_ = tracking; }
  /// Goes on in another map.
  void setMap(std::shared_ptr<const LocalizationMap> map);

  /// Whether there is a pose, however good.
  bool isInitialized() const { return initial_.has_value(); }
  const LocalizationMap& map() const { return *map_; }
  const PoseFilter& filter() const { return filter_; }
  LocalizerState state() const { return state_; }

  /// Predicts to the input's time and uses its images where they are fit for it. Bad input is
  /// reported in the result, not thrown.
  LiveResult process(const LiveInput& input);

 private:
  void begin();
  bool advanceTo(const LiveInput& input, LiveResult* result);
  bool hasMoved(const LiveInput& input) const;
  void processImages(const LiveInput& input, LiveResult* result);
  std::vector<CameraView> prepare(const LiveInput& input, LiveResult* result, std::string* problem);
  std::string useImages(std::vector<CameraView> views, LiveResult* result);
  void beginSearch(bool only_around);
  static bool showWhatIsNotInView(const std::vector<CameraView>& views);
  bool isSpreadWide() const;
  bool isLeftToSearch(const LiveInput& input) const;
  void search(const LiveInput& input, const std::vector<CameraView>& views, LiveResult* result);
  bool agreesWith(const SearchReport& report) const;
  bool weigh(double time, const LiveResult& result);
  /// The view's mask, lifted where the model is seen under it.
  cv::Mat maskOf(size_t number, const LiveInput::View& view);
  void learnUnderMasks(const LiveInput& input, bool used);
  void prepareImages(const LiveInput& input, LiveResult* result, std::vector<CameraView>* views,
                     std::string* problem);
  std::vector<CameraView> prepareDepths(const LiveInput& input, std::string* problem) const;
  bool isConfirmed(const LiveResult& result) const;
  void judge(double time, bool trusted, bool used);

  std::shared_ptr<const LocalizationMap> map_;
  TrackingParameters tracking_;
  PoseFilter filter_;
  PoseProof proof_;
  MaskLifter mask_lifter_;
  std::optional<PoseGaussian> initial_;
  std::optional<PoseGaussian> given_;  // not found by the search: where a clock turned back begins
  LocalizerState state_ = LocalizerState::kUninitialized;
  bool fresh_ = false;  // no image since the pose was given
  std::optional<double> last_time_;
  double longest_interval_ = 0;  // s, between inputs of late; 0: not known
  std::optional<Pose> last_odometry_;
  std::optional<Pose> odometry_of_update_;  // where the images were last used
  std::optional<double> trusted_at_;        // last time, or when it began
  bool trusted_ = false;                    // after the image that was last looked at
  const bool search_in_background_;
  std::unique_ptr<PoseFinder> finder_;  // made when first needed
  bool searching_ = false;
  bool only_around_ = false;  // the search looks around the given pose only
};

}  // namespace edge_mcl
