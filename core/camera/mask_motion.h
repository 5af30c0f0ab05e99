/// Transfer of an older mask to a newer image.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "edge_mcl/core/camera/camera_model.h"

namespace edge_mcl {

/// Turns a mask with the camera. The ray of every pixel is looked up in the older mask. Translation
/// of the camera and motion of the object are not considered, because they need the distance of the
/// object.
/// @param R_now_then rotation from the camera axes at the time of the mask to the camera axes now.
cv::Mat turnMask(const cv::Mat& mask, const CameraModel& camera, const Eigen::Matrix3d& R_now_then);

}  // namespace edge_mcl
