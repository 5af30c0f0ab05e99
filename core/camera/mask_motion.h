/// An older mask, carried over to a newer image.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "edge_mcl/core/camera/camera_model.h"

namespace edge_mcl {

/// Turns a mask with the camera: every pixel's ray is looked up in the older image. Translation and
/// the object's own motion are left out, as they need its distance.
/// @param R_now_then rotation from the camera's axes at the mask's time to those now.
cv::Mat turnMask(const cv::Mat& mask, const CameraModel& camera, const Eigen::Matrix3d& R_now_then);

}  // namespace edge_mcl
