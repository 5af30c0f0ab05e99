/// Spoils rendered images as a real camera does: brightness, noise, motion blur, dropped images.
#pragma once

#include <opencv2/core.hpp>

#include "edge_mcl/core/base/random_source.h"

namespace edge_mcl {

/// Faults of a simulated camera, the key `faults` of a scenario.
struct CameraFaults {
  double noise = 2;            ///< standard deviation of the pixel noise, grey levels
  double exposure_swing = 0;   ///< largest relative change of the brightness, see exposureAt()
  double exposure_period = 7;  ///< period of the brightness, s
  double exposure_time = 0;    ///< s; motion blur: the mean of `blur_steps` images in this time
  int blur_steps = 5;
  double dropped = 0;  ///< share of images that never arrive
  /// Noise of the depth images, 1/m: at the depth z its standard deviation is depth_noise z^2, and
  /// the depth has steps of twice that. A Kinect has 0.0014 (K. Khoshelham, S. Oude Elberink,
  /// "Accuracy and resolution of Kinect depth data", Sensors 12, 2012).
  double depth_noise = 0;
  double depth_range = 100;  ///< m; farther surfaces have no depth
};

/// Returns the brightness factor at a time (s): 1 + exposure_swing * sin(2 pi time / period).
double exposureAt(const CameraFaults& faults, double time);

/// Applies the brightness factor and the noise to an image in place. Motion blur and dropped images
/// are the Simulator's work. @param time s. @param seed of the noise; every image has its own.
/// @param color CV_8UC3.
void spoil(const CameraFaults& faults, double time, uint64_t seed, cv::Mat* color);
/// Adds noise, steps and range to a depth image (CV_32F, m).
/// @param seed of the noise; the same seed gives the same noise.
void spoilDepth(const CameraFaults& faults, uint64_t seed, cv::Mat* depth);

}  // namespace edge_mcl
