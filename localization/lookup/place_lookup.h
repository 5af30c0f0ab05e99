/// Compares the straight lines of one image with what all places see.
#pragma once

#include <functional>
#include <vector>

#include "edge_mcl/core/base/se3.h"
#include "edge_mcl/core/places/prepared_places.h"
#include "edge_mcl/localization/lookup/image_lines.h"

namespace edge_mcl {

/// A pose of the camera that may explain an image.
struct LookupPose {
  Pose T_map_camera = Pose::Identity();
  double score = 0;  ///< nats against chance
};

/// Scores every place with every orientation that makes the straight lines of the image parallel to
/// the axes of the building.
/// @param most number of poses. @param filter tells which positions (map frame) count; null: all.
/// @return best first, at most two orientations of a place. Empty when the image has too few lines.
std::vector<LookupPose> lookUp(const PreparedPlaces& places, const EdgeImage& image,
                               const CameraModel& camera, const KnownUp& up, size_t most,
                               const std::function<bool(const Eigen::Vector3d&)>& filter = nullptr);

/// The same for known lines and orientations.
/// @param rotations of the camera, up to quarter turns, which are all tried.
/// @param ignore CV_8U mask of the image, may be empty.
std::vector<LookupPose> lookUp(const PreparedPlaces& places, const std::vector<ImageLine>& lines,
                               const std::vector<AxesRotation>& rotations,
                               const CameraModel& camera, const cv::Mat& ignore, size_t most,
                               const std::function<bool(const Eigen::Vector3d&)>& filter = nullptr);

}  // namespace edge_mcl
