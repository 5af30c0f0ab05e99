/// Reads images and range images from MRPT observations for the localizer.
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

/// The camera image of an observation.
struct ObservedImage {
  cv::Mat pixels, mask;  ///< they share the memory of the observation; empty mask: no mask
  CameraModel camera;
  Pose T_base_camera = Pose::Identity();  ///< optical axes
};

/// The range image of an observation, as a depth image.
struct ObservedDepth {
  DepthImage image;
  Pose T_base_camera = Pose::Identity();  ///< optical axes
};

/// Name of an observation for error messages: "image observation 'LABEL'".
std::string originOf(const mrpt::obs::CObservation& obs);

/// Whether imageOf() returns an image.
bool hasImage(const mrpt::obs::CObservation& obs);
/// Whether depthOf() returns a range image.
bool hasDepth(const mrpt::obs::CObservation& obs);

/// Reads the image of a CObservationImage, a CObservationMaskedImage or a CObservation3DRangeScan.
/// The result is empty for other observations. @param calibration used for images without one, as
/// MRPT's rosbag2rawlog writes them; may be null. @throws InputError when the image cannot be read
/// or the camera is not valid.
std::optional<ObservedImage> imageOf(const mrpt::obs::CObservation& obs,
                                     const CameraModel* calibration);
/// Reads the range image of a CObservation3DRangeScan and converts it to depths along the optical
/// axis. The result is empty for other observations. @throws InputError when the range image cannot
/// be read or has no unit, or the camera is not valid.
std::optional<ObservedDepth> depthOf(const mrpt::obs::CObservation& obs);

/// The range image as stored, CV_16U; shares the memory of the observation. Empty for observations
/// without range image. @throws InputError when its file cannot be read.
cv::Mat rangesOf(const mrpt::obs::CObservation& obs);

/// T_base_camera of the depth sensor of a CObservation3DRangeScan, optical axes.
Pose depthMountingOf(const mrpt::obs::CObservation& obs);
/// Key of the range image of a CObservation3DRangeScan, like keyOf(). Camera and unit of the ranges
/// are part of it.
uint64_t depthKeyOf(const mrpt::obs::CObservation& obs);

/// Key of an image: a hash of the observation's address, its time, and a sample of the pixels of
/// image and mask. It tells images apart without a look at every pixel.
uint64_t keyOf(const mrpt::obs::CObservation& obs, const cv::Mat& pixels, const cv::Mat& mask);

}  // namespace edge_mcl
