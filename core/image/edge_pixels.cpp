#include "edge_mcl/core/image/edge_pixels.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <cmath>
#include <cstring>

namespace edge_mcl {

EdgePixels::EdgePixels(const EdgeImage& image)
    : width_(image.width()),
      height_(image.height()),
      edges_(image.edges),
      number_(static_cast<size_t>(width_) * height_) {
  for (int y = 0; y < height_; ++y) {
    const uint8_t* row = image.edges.ptr<uint8_t>(y);
    for (int x = 0; x < width_; ++x) {
      uint64_t eight = 1;  // eight pixels at once, because most of the image is empty
      if (x + 8 <= width_) std::memcpy(&eight, row + x, 8);
      if (eight == 0) {
        x += 7;
        continue;
      }
      if (!row[x]) continue;
      number_[static_cast<size_t>(y) * width_ + x] = static_cast<int32_t>(list_.size());
      list_.push_back({x, y});
    }
  }
  tbb::parallel_for(tbb::blocked_range<size_t>(0, list_.size(), 1024),
                    [&](const tbb::blocked_range<size_t>& range) {
                      for (size_t i = range.begin(); i < range.end(); ++i) {
                        EdgePixel& p = list_[i];
                        const Eigen::Vector2d normal = image.normalAt(p.x, p.y);
                        const Eigen::Vector2d ridge = image.subPixel(p.x, p.y, normal);
                        p.normal_x = static_cast<float>(normal.x());
                        p.normal_y = static_cast<float>(normal.y());
                        p.ridge_x = static_cast<float>(ridge.x());
                        p.ridge_y = static_cast<float>(ridge.y());
                      }
                    });
}

const EdgePixel* EdgePixels::nearestAlong(float u, float v, float nx, float ny, float length,
                                          float tolerance_cos) const {
  // Fixed point: after 200 pixels in half-pixel steps the error is less than a hundredth of a
  // pixel.
  constexpr float kOne = 65536;
  const auto fixed = [](float value) { return static_cast<int32_t>(kOne * value); };
  const int32_t u0 = fixed(u + 0.5f), v0 = fixed(v + 0.5f);
  const int32_t du = fixed(0.5f * nx), dv = fixed(0.5f * ny);
  const auto width = static_cast<uint32_t>(width_), height = static_cast<uint32_t>(height_);
  const auto edgeAt = [&](int32_t fixed_u, int32_t fixed_v) -> const EdgePixel* {
    const auto x = static_cast<uint32_t>(fixed_u >> 16), y = static_cast<uint32_t>(fixed_v >> 16);
    if (x >= width || y >= height || !edges_.data[y * edges_.step + x]) return nullptr;
    const EdgePixel& p = list_[number_[static_cast<size_t>(y) * width_ + x]];
    return std::abs(p.normal_x * nx + p.normal_y * ny) >= tolerance_cos ? &p : nullptr;
  };
  if (const EdgePixel* p = edgeAt(u0, v0)) return p;
  const int steps = static_cast<int>(2 * length);
  for (int i = 1; i <= steps; ++i) {
    if (const EdgePixel* p = edgeAt(u0 + i * du, v0 + i * dv)) return p;
    if (const EdgePixel* p = edgeAt(u0 - i * du, v0 - i * dv)) return p;
  }
  return nullptr;
}

}  // namespace edge_mcl
