#include "edge_mcl/core/camera/mask_motion.h"

#include <Eigen/LU>
#include <opencv2/imgproc.hpp>

namespace edge_mcl {

cv::Mat turnMask(const cv::Mat& mask, const CameraModel& camera,
                 const Eigen::Matrix3d& R_now_then) {
  // This is the homography of a pinhole camera that turns. Lens distortion changes it by less than
  // the dilation of masks.
  Eigen::Matrix3d k;
  k << camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1;
  const Eigen::Matrix3d h = k * R_now_then * k.inverse();
  const cv::Matx33d homography(h(0, 0), h(0, 1), h(0, 2), h(1, 0), h(1, 1), h(1, 2), h(2, 0),
                               h(2, 1), h(2, 2));
  cv::Mat turned;
  cv::warpPerspective(mask, turned, homography, mask.size(), cv::INTER_NEAREST, cv::BORDER_CONSTANT,
                      cv::Scalar(0));
  // The homography also maps rays that pointed backwards in the older camera. There the third
  // coordinate of the older ray is not positive.
  const Eigen::RowVector3d depth = (k * R_now_then.transpose() * k.inverse()).row(2);
  for (int y = 0; y < turned.rows; ++y)
    for (int x = 0; x < turned.cols; ++x)
      if (depth[0] * x + depth[1] * y + depth[2] <= 0) turned.at<uint8_t>(y, x) = 0;
  return turned;
}

}  // namespace edge_mcl
