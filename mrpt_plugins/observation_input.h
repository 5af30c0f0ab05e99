/// What MRPT's observations hold for the localizer.
#pragma once

#include <mrpt/obs/CObservation.h>

#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "edge_mcl/core/base/se3.h"
#include "edge_mcl/core/camera/camera_model.h"
#include "edge_mcl/core/depth/depth_points.h"

namespace edge_mcl {

struct ObservedImage {
  cv::Mat pixels, mask;  ///< of the observation, not copied; mask empty: none
  CameraModel camera;
  Pose T_base_camera = Pose::Identity();
};

struct ObservedDepth {
  DepthImage image;
  Pose T_base_camera = Pose::Identity();  ///< optical axes
};

/// "image observation 'LABEL'", for errors.
std::string originOf(const mrpt::obs::CObservation& obs);

bool hasImage(const mrpt::obs::CObservation& obs);
bool hasDepth(const mrpt::obs::CObservation& obs);

/// The image of a CObservationImage, a CObservationMaskedImage or a CObservation3DRangeScan;
/// nothing for others. @param calibration of images that come without, as MRPT's rosbag2rawlog
/// writes them; may be null. @throws InputError on a broken image or camera.
std::optional<ObservedImage> imageOf(const mrpt::obs::CObservation& obs,
                                     const CameraModel* calibration);
/// The range image of a CObservation3DRangeScan; nothing for others. @throws InputError likewise.
std::optional<ObservedDepth> depthOf(const mrpt::obs::CObservation& obs);

/// The range image's own numbers, not copied; empty for observations without.
cv::Mat rangesOf(const mrpt::obs::CObservation& obs);

/// Where the depth sensor of a CObservation3DRangeScan is, optical axes.
Pose depthMountingOf(const mrpt::obs::CObservation& obs);
/// As keyOf, with all that makes points of the ranges.
uint64_t depthKeyOf(const mrpt::obs::CObservation& obs);

/// Tells observations apart without reading all of their pixels.
uint64_t keyOf(const mrpt::obs::CObservation& obs, const cv::Mat& pixels, const cv::Mat& mask);

}  // namespace edge_mcl
