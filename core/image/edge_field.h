/// Distance to the nearest image edge of matching direction, along the normal of a model edge,
/// for every pixel and every direction: the search of the paper, done once per image.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstdint>
#include <vector>

#include "edge_mcl/core/base/large_buffer.h"
#include "edge_mcl/core/base/parameters.h"
#include "edge_mcl/core/image/edge_pixels.h"
#include "edge_mcl/core/image/image_edges.h"

namespace edge_mcl {

/// Direction of an undirected line in the image as a number in [0, 2): the position on the unit
/// diamond |du| + |dv| = 1, a monotone stand-in for the angle in [0, pi) without trigonometry.
double diamondAngle(double du, double dv);
/// Unit direction of a diamond angle.
Eigen::Vector2d diamondDirection(double diamond_angle);

/// The normals that are searched: one direction per bin, walked in steps of one pixel along the
/// longer axis.
class SearchGeometry {
 public:
  struct Walk {
    float du, dv;     ///< unit direction of the model edge
    bool transposed;  ///< the normal's longer axis is the image's rows': columns are walked
    double slope;     ///< pixels to the side per step along the longer axis
  };
  explicit SearchGeometry(const ImageParameters& params);
  int bins() const { return static_cast<int>(step_length_.size()); }
  /// Longest normal, pixels.
  double length() const { return length_; }
  /// Length of one step along the normal of a bin, pixels (1 to sqrt 2).
  double stepLength(int bin) const { return step_length_[bin]; }
  const Walk& walk(int bin) const { return walk_[bin]; }
  /// What stands for "no edge in reach": one more than the steps that are.
  uint8_t noEdge(int bin) const { return no_edge_[bin]; }

 private:
  double length_;
  std::vector<Walk> walk_;
  std::vector<double> step_length_;
  std::vector<uint8_t> no_edge_;
};

/// Table over bins of the edge's direction; bin b stands for the diamond angle 2 b / bins.
class EdgeField {
 public:
  /// Cells in either direction over which the density of edges is measured.
  static int windowCells(const ImageParameters& params) {
    return std::max(1, params.clutter_window / kClutterCell) | 1;
  }
  /// @param pixels of the image.
  EdgeField(const EdgeImage& image, const EdgePixels& pixels, const ImageParameters& params);

  int width() const { return width_; }
  int height() const { return height_; }
  int bins() const { return search_.bins(); }
  const SearchGeometry& search() const { return search_; }
  /// Steps along the normal to the nearest edge, rows of stepsStride() elements, readable up to
  /// the next multiple of eight; search().noEdge(bin) where none is in reach.
  const uint8_t* steps(int bin) const { return &steps_[static_cast<size_t>(bin) * plane() + 1]; }
  size_t stepsStride() const { return stride_; }
  /// Distance in pixels, infinity where no edge is in reach.
  double distance(int bin, int x, int y) const;
  /// Density of edges of this direction around a pixel: edges per pixel along the normal, one
  /// isolated line through the window not counted.
  double clutter(int bin, int x, int y) const {
    return clutter_[(static_cast<size_t>(bin) * clutter_rows_ + y / kClutterCell) *
                        clutter_columns_ +
                    x / kClutterCell];
  }
  static constexpr int kClutterCell = 8;  ///< pixels over which the density is constant
  /// CV_8U ignore mask, empty without one.
  const cv::Mat& ignore() const { return ignore_; }

 private:
  size_t plane() const { return stride_ * height_; }
  int width_, height_;
  SearchGeometry search_;
  size_t stride_;  // a column more on either side, always without edges
  LargeBuffer<uint8_t> steps_;
  int clutter_rows_, clutter_columns_;
  std::vector<float> clutter_;
  cv::Mat ignore_;
};

/// An image edge found on the normal of a model edge.
struct NormalHit {
  bool found = false;
  double distance = 0;  ///< signed, pixels along the normal
  int x = 0, y = 0;     ///< the edge pixel
};

/// The search to the letter: walks from `pixel` along `normal` (unit) to both sides in half-pixel
/// steps, at most `length` pixels, to the nearest edge whose direction differs by at most
/// `tolerance_cos` (cosine) from the model edge's.
NormalHit searchAlongNormal(const EdgeImage& image, const Eigen::Vector2d& pixel,
                            const Eigen::Vector2d& normal, double length, double tolerance_cos);

}  // namespace edge_mcl
