/// Pinhole camera with the distortion models of ROS `camera_info`.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <string>

namespace edge_mcl {

/// Lens distortion models, see CameraModel.
enum class DistortionModel { kNone, kPlumbBob, kRationalPolynomial, kEquidistant };

/// Intrinsics of a camera. The camera frame is optical (x right, y down, z forward). The centre of
/// the top-left pixel is (0, 0).
///
/// Distortion models, with (x, y) = (X/Z, Y/Z) and r2 = x^2 + y^2, as in the OpenCV documentation:
///  - plumb_bob, coefficients (k1 k2 p1 p2 k3);
///  - rational_polynomial (k1 k2 p1 p2 k3 k4 k5 k6);
///  - equidistant (k1 k2 k3 k4): theta_d = theta (1 + k1 theta^2 + ... + k4 theta^8).
struct CameraModel {
  int width = 0;                          ///< pixels
  int height = 0;                         ///< pixels
  double fx = 0, fy = 0, cx = 0, cy = 0;  ///< pixels
  DistortionModel distortion = DistortionModel::kNone;
  std::array<double, 8> coefficients{};
  /// Limit of r2 (equidistant: theta^2). Points beyond it are outside the monotone part of the
  /// distortion and would fold back into the image. Set by validate().
  double max_radius2 = 1e12;
  /// Generous bounds of the directions that the image shows, for culling. Set by validate().
  struct View {
    double angle = M_PI;  ///< largest angle between the optical axis and a ray, radians
    double x_min = -1e6, x_max = 1e6, y_min = -1e6, y_max = 1e6;  ///< of X/Z and Y/Z
  } view;

  /// Checks the numbers and computes max_radius2 and view. If all coefficients are 0, plumb_bob and
  /// rational_polynomial become kNone.
  /// @param origin named in errors.
  /// @throws InputError that lists every fault.
  void validate(const std::string& origin);

  /// Projects a point of the camera frame (metres) to a pixel.
  /// @param jacobian optional: d(u, v) / d(X, Y, Z).
  /// @return false when the point is closer than kMinDepth, behind the camera, or outside the valid
  ///   cone. The pixel of a projected point may lie outside the image.
  bool project(const Eigen::Vector3d& point, Eigen::Vector2d* pixel,
               Eigen::Matrix<double, 2, 3>* jacobian = nullptr) const;

  /// max_radius2 as a limit of (X/Z)^2 + (Y/Z)^2, for every distortion model.
  double maxPlaneRadius2() const;

  /// Whether a pixel is inside the image.
  bool contains(const Eigen::Vector2d& pixel) const {
    return pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() <= width - 1 && pixel.y() <= height - 1;
  }

  /// Reads a calibration file in one of these formats of YAML: ROS camera_calibration, OpenCV's
  /// calibration samples, Kalibr's camchain, EuRoC's sensor.yaml, ORB-SLAM 2 and 3, VINS-Fusion.
  /// @param file may end in `:NAME`, which chooses one of several cameras of a file
  /// ("chain.yaml:cam1").
  /// @throws InputError that names the file, and the missing or wrong key or what to do.
  static CameraModel fromYamlFile(const std::string& file);
  /// Makes a camera from the fields of a camera_info message.
  /// @param k camera matrix, row-major. A skew that moves no pixel by more than half a pixel is
  /// left
  ///   out.
  /// @param distortion_model a name of REP 104 or of another calibration tool. When it is empty,
  /// the
  ///   coefficients are those of OpenCV.
  /// @param d distortion coefficients, `d_size` of them, in OpenCV's order.
  /// @param origin named in errors.
  /// @throws InputError when a field is wrong.
  static CameraModel fromFields(int width, int height, const std::array<double, 9>& k,
                                const std::string& distortion_model, const double* d, size_t d_size,
                                const std::string& origin);
  /// Depth up to which nothing is projected, metres.
  static constexpr double kMinDepth = 0.01;
};

}  // namespace edge_mcl
