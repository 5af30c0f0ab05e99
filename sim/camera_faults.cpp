#include "edge_mcl/sim/camera_faults.h"

#include <cmath>

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

}  // namespace edge_mcl
