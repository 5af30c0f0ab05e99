/// A depth image as a list of points.
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "edge_mcl/core/base/parameters.h"
#include "edge_mcl/core/base/se3.h"
#include "edge_mcl/core/camera/camera_model.h"

namespace edge_mcl {

/// An image and a depth image belong to one moment when their times differ by at most this, s.
/// Depth cameras run beside the colour camera, and this is less than a frame at 30 Hz.
constexpr double kDepthWindow = 0.025;

/// One depth image as it is received.
struct DepthImage {
  CameraModel camera;
  cv::Mat depth;  ///< CV_16U or CV_32F, depth along the optical axis; 0 or not finite: no return
  double units_per_metre = 1000;  ///< of CV_16U images; CV_32F images are in metres
  std::string origin;             ///< named in errors
  /// Pixels to ignore. The mask may belong to another camera.
  struct Mask {
    cv::Mat pixels;      ///< CV_8U, non-zero: ignored; empty: none
    CameraModel camera;  ///< camera of the mask
    /// Pose of the depth camera in the frame of the mask's camera.
    Pose T_mask_depth = Pose::Identity();
  };
  /// A mask of the depth image itself has the same camera and an identity pose.
  std::optional<Mask> mask;
};

/// @throws InputError when the type or size of depth image or mask is wrong.
void checkDepth(const DepthImage& image);
/// Depth of a pixel, m; 0: no return.
double metresAt(const DepthImage& image, int x, int y);

/// Points of a thinned-out depth image, in the depth camera's optical frame, metres. Every
/// coordinate is an array of its own for the vector unit. The arrays are padded to a multiple of
/// kPadding with points of no weight.
struct DepthPoints {
  static constexpr size_t kPadding = 16;
  size_t count = 0;       ///< number of points without the padding
  double returned = 0;    ///< share of the examined pixels outside the mask with a depth in range
  double mean_depth = 0;  ///< mean depth of the points, m
  std::vector<float> x, y, z;
  std::vector<float> inverse_variance;  ///< 1 / variance of the distance from the surface, 1/m^2
  /// As inverse_variance, without the part of the bias, for estimates that model the bias.
  std::vector<float> inverse_noise;
  double bias_variance = 0;  ///< variance of the bias that remains after withoutBias(), 1/m^2
};

/// Systematic error of a depth sensor: at the depth z it reads z - mean z^2. An offset of the
/// disparities causes this error, with structured light and with stereo (K. Khoshelham, S. Oude
/// Elberink, "Accuracy and resolution of Kinect depth data", Sensors 12, 2012).
struct DepthBias {
  double mean = 0;      ///< 1/m
  double variance = 0;  ///< 1/m^2
};

/// Removes the bias from the points, and adds the noise that comes from its uncertainty.
DepthPoints withoutBias(const DepthPoints& points, const DepthBias& bias);

/// Makes at most `params.points` points. They are taken evenly from the pixels that have a depth in
/// range and are not ignored.
/// @throws InputError when the type or size of depth image or mask is wrong.
DepthPoints makeDepthPoints(const DepthImage& image, const DepthParameters& params);

}  // namespace edge_mcl
