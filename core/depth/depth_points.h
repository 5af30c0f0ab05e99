/// A depth image as points.
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "edge_mcl/core/base/parameters.h"
#include "edge_mcl/core/base/se3.h"
#include "edge_mcl/core/camera/camera_model.h"

namespace edge_mcl {

/// A depth image this close to an image is of the same moment, s: depth cameras run beside the
/// colour camera, and this is less than a frame at 30 Hz.
constexpr double kDepthWindow = 0.025;

/// One depth image as it comes.
struct DepthImage {
  CameraModel camera;
  cv::Mat depth;  ///< CV_16U or CV_32F: depth along the optical axis; 0 or not finite: no return
  double units_per_metre = 1000;  ///< of CV_16U; CV_32F is in metres
  std::string origin;             ///< named in errors
  /// What to ignore; the mask may be that of another camera.
  struct Mask {
    cv::Mat pixels;                        ///< CV_8U, non-zero: ignored; empty: none
    CameraModel camera;                    ///< of the mask
    Pose T_mask_depth = Pose::Identity();  ///< where the depth camera is in the mask's camera
  };
  std::optional<Mask> mask;  ///< of the depth image itself if `camera` is the same
};

/// A thinned-out depth image. Points are in the depth camera's optical frame, metres; each as
/// arrays for the vector unit, padded to a multiple of kPadding with points of no weight.
struct DepthPoints {
  static constexpr size_t kPadding = 16;
  size_t count = 0;       ///< points, without the padding
  double returned = 0;    ///< share of the pixels looked at that gave a point in range
  double mean_depth = 0;  ///< m
  std::vector<float> x, y, z;
  std::vector<float> inverse_variance;  ///< of the distance from the surface, 1/m^2
  double bias_variance = 0;             ///< of what is left of DepthBias, 1/m^2
};

/// The systematic error of a depth sensor: it reads z - mean z^2 at the depth z. That is what an
/// offset of the disparities does, of structured light and stereo alike (K. Khoshelham, S. Oude
/// Elberink, "Accuracy and resolution of Kinect depth data", Sensors 12, 2012).
struct DepthBias {
  double mean = 0;      ///< 1/m
  double variance = 0;  ///< 1/m^2
};

/// The points without the bias, and with the noise that its uncertainty adds.
DepthPoints withoutBias(const DepthPoints& points, const DepthBias& bias);

/// Takes about `params.points` pixels, evenly from those that have a depth in range and are not
/// ignored. @throws InputError on a wrong type or size.
DepthPoints makeDepthPoints(const DepthImage& image, const DepthParameters& params);

}  // namespace edge_mcl
