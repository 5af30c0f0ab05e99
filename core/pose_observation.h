/// How the lines of the model fit the images of one moment at a pose, and how far an error of a
/// line or of a calibration would move that pose.
///
/// A refined pose solves `information * xi = sum_l pull_l * b_l`. The sum is over pieces of lines,
/// and b_l is the offset between a piece and its image edge. The pulls are the sensitivities of a
/// Schmidt-Kalman filter (S. F. Schmidt, "Application of state-space methods to navigation
/// problems", 1966) and the clusters of a sandwich estimator (H. White, Econometrica 48(4), 1980).
#pragma once

#include <cstdint>
#include <vector>

#include "edge_mcl/core/base/se3.h"

namespace edge_mcl {

/// Normal equations of one image, of the pose and of three errors of the calibration: relative
/// error of the focal length (1), error of the principal point in x and y (pixels). All parts have
/// the weights of the last step of a refinement.
struct CameraObservation {
  Matrix6 pose_information = Matrix6::Zero();  ///< base frame
  Twist pose_gradient = Twist::Zero();
  /// Right side of the pose's equations per unit of each error.
  Eigen::Matrix<double, 6, 3> pull = Eigen::Matrix<double, 6, 3>::Zero();
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
};

/// See the top of this file.
struct PoseObservation {
  /// Half of a line in one image. Halves tell an offset of a line from a turn.
  struct Piece {
    uint32_t key = 0;                ///< equal for the same half of the same line in all images
    Vector6 pull = Vector6::Zero();  ///< per scaled pixel of offset, base frame
    double offset = 0;               ///< weighted mean residual at the pose, scaled pixels
    double weight = 0;               ///< sum of the weights, 1/pixel^2
    double samples = 0;              ///< number of matched samples, each line saturated
  };
  std::vector<Piece> pieces;                    ///< those with matched samples
  std::vector<CameraObservation> cameras;       ///< one for every view with an image
  Matrix6 information = Matrix6::Zero();        ///< of all images, base frame
  Matrix6 depth_information = Matrix6::Zero();  ///< of all depth images, base frame
};

}  // namespace edge_mcl
