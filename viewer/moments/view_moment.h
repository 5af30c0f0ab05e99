/// Defines one moment as the viewer shows it, for recordings and live data.
#pragma once

#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "edge_mcl/localization/tracking/live_localizer.h"

namespace edge_mcl {

/// An object that a detector found in the image.
struct ShownObject {
  std::string name;  ///< of its class
  float score = 0;
  int track = -1;  ///< number of the track; -1: not tracked
  cv::Rect2f box;  ///< pixels
};

/// Times of the stages of an update, ms.
struct UpdateTimes {
  static constexpr size_t kStages = 5;
  /// Name of a stage for the viewer's legend.
  static const char* name(size_t stage);
  double stage[kStages] = {};  ///< image edges, score table, likelihood, refinement, search
  double total = 0;
};

/// All that the viewer shows of one moment.
struct ViewMoment {
  double time = 0;     ///< s
  double elapsed = 0;  ///< s since the first moment
  LocalizerState state = LocalizerState::kUninitialized;
  std::string problem;  ///< one line; empty: none
  bool has_pose = false;
  PoseGaussian estimate;              ///< T_map_base
  std::vector<Pose> particles;        ///< T_map_base; a part of them when there are very many
  std::vector<float> weights;         ///< of `particles`, the largest is 1; empty: unknown
  size_t particle_count = 0;          ///< number of all particles of the filter
  std::vector<PoseCluster> clusters;  ///< hypotheses during a search
  std::vector<Pose> next_view;        ///< T_map_base of the next view at the two best of them
  std::optional<Pose> truth;          ///< T_map_base
  std::vector<ObjectState> foreign;   ///< objects that are not in the model

  bool has_camera = false;  ///< whether calibration and extrinsics are known
  CameraModel camera;
  Pose T_base_camera = Pose::Identity();
  cv::Mat image;                                  ///< as received, see shownImage(); empty: none
  cv::Mat mask;                                   ///< CV_8U, non-zero: ignored; empty: none
  std::shared_ptr<const PreparedImage> prepared;  ///< of the image; null: the viewer makes it
  std::vector<ShownObject> objects;
  std::vector<Eigen::Vector3f> depth_points;  ///< base frame, m

  double effective_sample_size = 0, match_ratio = 0;
  UpdateTimes times;
};

/// Makes a moment from the input and the result of a localizer. Particles are thinned out to at
/// most `max_particles`. @param truth T_map_base.
ViewMoment momentOf(const LiveInput& input, const LiveResult& result,
                    const LiveLocalizer& localizer, const std::optional<Pose>& truth,
                    size_t max_particles);

/// Converts an image of 8 or 16 bits with 1, 3 or 4 channels to CV_8UC1 or CV_8UC3. Any other image
/// becomes black.
cv::Mat shownImage(const cv::Mat& image);

/// Returns up to 1500 points of a depth image, base frame, m.
std::vector<Eigen::Vector3f> shownPoints(const DepthImage& image, const Pose& T_base_camera);

}  // namespace edge_mcl
