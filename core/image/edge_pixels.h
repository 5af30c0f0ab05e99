/// The edge pixels of an image as a list, with all that matching asks of them.
#pragma once

#include <cstdint>
#include <vector>

#include "edge_mcl/core/base/large_buffer.h"
#include "edge_mcl/core/image/image_edges.h"

namespace edge_mcl {

struct EdgePixel {
  int x = 0, y = 0;
  float normal_x = 0, normal_y = 0;  ///< unit gradient; zero where it vanishes
  float ridge_x = 0, ridge_y = 0;    ///< EdgeImage::subPixel
};

/// Made once per image: gradients and sub-pixel positions are asked for many times per pixel.
class EdgePixels {
 public:
  EdgePixels() = default;
  /// Keeps the image's edges, which must not change afterwards.
  explicit EdgePixels(const EdgeImage& image);

  /// By rows, then columns.
  const std::vector<EdgePixel>& list() const { return list_; }
  int width() const { return width_; }
  int height() const { return height_; }

  /// searchAlongNormal(), in single precision: the nearest edge pixel within `length` pixels to
  /// either side of (u, v) along the unit normal (nx, ny) whose gradient is within `tolerance_cos`
  /// of it. @return null when there is none.
  const EdgePixel* nearestAlong(float u, float v, float nx, float ny, float length,
                                float tolerance_cos) const;

 private:
  int width_ = 0, height_ = 0;
  std::vector<EdgePixel> list_;
  cv::Mat edges_;                // CV_8U, 0: no edge
  LargeBuffer<int32_t> number_;  // of every edge pixel, into list_; of other pixels undefined
};

}  // namespace edge_mcl
