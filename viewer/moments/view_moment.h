/// One moment as the viewer shows it, whatever it comes from.
#pragma once

#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "edge_mcl/localization/tracking/live_localizer.h"

namespace edge_mcl {

/// Something that a detector found in the image.
struct ShownObject {
  std::string name;  ///< of its class
  float score = 0;
  int track = -1;  ///< -1: not tracked
  cv::Rect2f box;  ///< pixels
};

/// Where the time of an update went, ms.
struct UpdateTimes {
  static constexpr size_t kStages = 5;
  static const char* name(size_t stage);
  double stage[kStages] = {};  ///< image edges, score table, likelihood, refinement, search
  double total = 0;
};

struct ViewMoment {
  double time = 0;     ///< s
  double elapsed = 0;  ///< s since the first moment
  LocalizerState state = LocalizerState::kUninitialized;
  std::string problem;  ///< one line; empty: none
  bool has_pose = false;
  PoseGaussian estimate;              ///< T_map_base
  std::vector<Pose> particles;        ///< T_map_base; some of them, where there are very many
  std::vector<float> weights;         ///< of these, largest 1; empty: all alike
  size_t particle_count = 0;          ///< of the filter
  std::vector<PoseCluster> clusters;  ///< while it searches
  std::optional<Pose> truth;          ///< T_map_base

  bool has_camera = false;  ///< calibration and mounting are known
  CameraModel camera;
  Pose T_base_camera = Pose::Identity();
  cv::Mat image;                                  ///< as it came, see shownImage; empty: none
  cv::Mat mask;                                   ///< CV_8U, non-zero: ignored; empty: none
  std::shared_ptr<const PreparedImage> prepared;  ///< of the image; null: the viewer prepares it
  std::vector<ShownObject> objects;
  std::vector<Eigen::Vector3f> depth_points;  ///< base axes, m

  double effective_sample_size = 0, match_ratio = 0;
  UpdateTimes times;
};

/// What a localizer made of an input. Particles beyond `max_particles` are thinned out.
ViewMoment momentOf(const LiveInput& input, const LiveResult& result,
                    const LiveLocalizer& localizer, const std::optional<Pose>& truth,
                    size_t max_particles);

/// An image as CV_8UC1 or CV_8UC3, whatever the localizer takes (16 bits, four channels); black
/// where it is nothing of the kind.
cv::Mat shownImage(const cv::Mat& image);

/// The points of a depth image, thinned out, in base axes.
std::vector<Eigen::Vector3f> shownPoints(const DepthImage& image, const Pose& T_base_camera);

}  // namespace edge_mcl
