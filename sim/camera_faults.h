/// What a real camera does to a perfect picture.
#pragma once

#include <opencv2/core.hpp>

#include "edge_mcl/core/base/random_source.h"

namespace edge_mcl {

struct CameraFaults {
  double noise = 2;            ///< standard deviation, grey levels
  double exposure_swing = 0;   ///< the brightness wanders by up to this share, slowly
  double exposure_period = 7;  ///< s
  double exposure_time = 0;    ///< s; motion blur is the mean of `blur_steps` pictures over it
  int blur_steps = 5;
  double dropped = 0;  ///< share of images that never arrive
};

/// Brightness factor at a time.
double exposureAt(const CameraFaults& faults, double time);

/// Exposure and noise, in place. @param seed of this image's noise.
void spoil(const CameraFaults& faults, double time, uint64_t seed, cv::Mat* color);

}  // namespace edge_mcl
