/// How well an image fits the model with a given calibration.
#pragma once

#include <vector>

#include "edge_mcl/core/localization_map.h"

namespace edge_mcl {

/// An image that is asked about its calibration, at a trusted pose.
struct AskedImage {
  const LocalizationMap& map;
  const cv::Mat& image;
  const cv::Mat& mask;  ///< as LocalizationMap::prepare() takes it
  Pose T_base_camera = Pose::Identity();
  Pose pose = Pose::Identity();  ///< T_map_base
};

/// The image, prepared with this calibration.
std::vector<CameraView> viewsOf(const AskedImage& asked, const CameraModel& camera);

/// Log-likelihood ratio of the views at the pose to which they refine a start (T_map_base), nats.
double fitOf(const LocalizationMap& map, const std::vector<CameraView>& views, const Pose& start);

}  // namespace edge_mcl
