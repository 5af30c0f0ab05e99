/// The edge pixels of an image as a list, with normals and sub-pixel positions.
#pragma once

#include <cstdint>
#include <vector>

#include "edge_mcl/core/base/large_buffer.h"
#include "edge_mcl/core/image/image_edges.h"

namespace edge_mcl {

/// An edge pixel with its normal and its position on the ridge of the gradient.
struct EdgePixel {
  int x = 0, y = 0;
  float normal_x = 0, normal_y = 0;  ///< unit gradient; zero where the gradient vanishes
  float ridge_x = 0, ridge_y = 0;    ///< sub-pixel position, see EdgeImage::subPixel()
};

/// List of the edge pixels of one image. It is made once per image, because matching reads the
/// gradient and the sub-pixel position of a pixel many times.
class EdgePixels {
 public:
  EdgePixels() = default;
  /// Shares the memory of image.edges, which must not change afterwards.
  explicit EdgePixels(const EdgeImage& image);

  /// All edge pixels, ordered by row, then column.
  const std::vector<EdgePixel>& list() const { return list_; }
  int width() const { return width_; }
  int height() const { return height_; }

  /// Does what searchAlongNormal() does, in single precision. It searches at most `length` pixels
  /// to either side of (u, v) along the unit normal (nx, ny). It returns the nearest edge pixel
  /// whose gradient differs from the normal by an angle with a cosine of at least `tolerance_cos`.
  /// @return null when there is none.
  const EdgePixel* nearestAlong(float u, float v, float nx, float ny, float length,
                                float tolerance_cos) const;

 private:
  int width_ = 0, height_ = 0;
  std::vector<EdgePixel> list_;
  cv::Mat edges_;  // CV_8U, 0: no edge
  // Of every edge pixel: index into list_; undefined for other pixels.
  LargeBuffer<int32_t> number_;
};

}  // namespace edge_mcl
