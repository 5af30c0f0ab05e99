#include "edge_mcl/sim/camera_faults.h"

#include <cmath>

#include "edge_mcl/core/base/random_source.h"

namespace edge_mcl {

double exposureAt(const CameraFaults& faults, double time) {
  return 1 + faults.exposure_swing * std::sin(2 * M_PI * time / faults.exposure_period);
}

void spoil(const CameraFaults& faults, double time, uint64_t seed, cv::Mat* color) {
  const double factor = exposureAt(faults, time);
  if (faults.noise <= 0) {
    if (factor != 1) color->convertTo(*color, -1, factor);
    return;
  }
  // All channels get the same noise, because demosaicing mixes the channels of a real sensor.
  cv::RNG random(seed * 0x9e3779b97f4a7c15ull + 1);
  cv::Mat noise(color->size(), CV_16S), all;
  random.fill(noise, cv::RNG::NORMAL, 0, 16 * faults.noise);  // unit: 1/16 grey level
  for (int y = 0; y < color->rows; ++y) {
    auto* pixel = color->ptr<cv::Vec3b>(y);
    const int16_t* n = noise.ptr<int16_t>(y);
    const auto scale = static_cast<int>(std::lround(factor * 4096));
    for (int x = 0; x < color->cols; ++x)
      for (int c = 0; c < 3; ++c)
        pixel[x][c] = cv::saturate_cast<uint8_t>((pixel[x][c] * scale + n[x] * 256 + 2048) >> 12);
  }
}

void spoilDepth(const CameraFaults& faults, uint64_t seed, cv::Mat* depth) {
  depth->setTo(0, *depth > faults.depth_range);
  if (faults.depth_noise <= 0) return;
  // The sensor measures disparities, which are proportional to the inverse depth.
  RandomSource random(seed);
  const double step = 2 * faults.depth_noise;
  for (int y = 0; y < depth->rows; ++y)
    for (int x = 0; x < depth->cols; ++x) {
      float& z = depth->at<float>(y, x);
      if (!(z > 0)) continue;
      const double inverse = 1 / static_cast<double>(z) + faults.depth_noise * random.normal();
      const double measured = step * std::round(inverse / step);
      z = measured > 0 ? static_cast<float>(1 / measured) : 0;
    }
}

}  // namespace edge_mcl
