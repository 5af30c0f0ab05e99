/// Distances from pixels to the nearest image edge of matching direction, along the normal of a
/// model edge. They are computed for every pixel and every direction: the search of the paper, done
/// once per image.
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

/// Direction of an undirected line in the image as a number in [0, 2). It is the position on the
/// unit diamond |du| + |dv| = 1. It grows with the angle in [0, pi) and needs no trigonometry.
double diamondAngle(double du, double dv);
/// Unit direction (du, dv) that has a diamond angle.
Eigen::Vector2d diamondDirection(double diamond_angle);

/// The normals along which image edges are searched: one direction per bin. A normal is walked in
/// steps of one pixel along its longer axis.
class SearchGeometry {
 public:
  struct Walk {
    float du, dv;     ///< unit direction of the model edge
    bool transposed;  ///< the longer axis of the normal is x: each step goes to the next column
    double slope;     ///< pixels to the side per step along the longer axis
  };
  explicit SearchGeometry(const ImageParameters& params);
  int bins() const { return static_cast<int>(step_length_.size()); }
  /// Largest distance searched to either side, pixels.
  double length() const { return length_; }
  /// Length of one step along the normal of a bin, pixels (1 to sqrt 2).
  double stepLength(int bin) const { return step_length_[bin]; }
  const Walk& walk(int bin) const { return walk_[bin]; }
  /// Number of steps that means "no edge in reach": one more than the largest number of steps in
  /// reach.
  uint8_t noEdge(int bin) const { return no_edge_[bin]; }

 private:
  double length_;
  std::vector<Walk> walk_;
  std::vector<double> step_length_;
  std::vector<uint8_t> no_edge_;
};

/// Tables of distances and edge densities for bins of the edge's direction. Bin b stands for the
/// diamond angle 2 b / bins.
class EdgeField {
 public:
  /// Side of the window in which the density of edges is measured, in cells. It is odd.
  static int windowCells(const ImageParameters& params) {
    return std::max(1, params.clutter_window / kClutterCell) | 1;
  }
  /// Computes the tables of an image. @param pixels edge pixels of the image.
  EdgeField(const EdgeImage& image, const EdgePixels& pixels, const ImageParameters& params);

  int width() const { return width_; }
  int height() const { return height_; }
  int bins() const { return search_.bins(); }
  const SearchGeometry& search() const { return search_; }
  /// Steps along the normal to the nearest edge, for all pixels of one bin. Rows have stepsStride()
  /// elements and are readable up to the next multiple of eight. The value is search().noEdge(bin)
  /// where no edge is in reach.
  const uint8_t* steps(int bin) const { return &steps_[static_cast<size_t>(bin) * plane() + 1]; }
  size_t stepsStride() const { return stride_; }
  /// Distance along the normal to the nearest edge, pixels. It is infinite where no edge is in
  /// reach.
  double distance(int bin, int x, int y) const;
  /// Density of edges of this direction around a pixel, in edges per pixel along the normal. One
  /// isolated line through the window does not count.
  double clutter(int bin, int x, int y) const {
    return clutter_[(static_cast<size_t>(bin) * clutter_rows_ + y / kClutterCell) *
                        clutter_columns_ +
                    x / kClutterCell];
  }
  /// Side of the cells in which the density is constant, pixels.
  static constexpr int kClutterCell = 8;
  /// Ignore mask, CV_8U; empty without a mask.
  const cv::Mat& ignore() const { return ignore_; }

 private:
  size_t plane() const { return stride_ * height_; }
  int width_, height_;
  SearchGeometry search_;
  size_t stride_;  // with one more column on either side, always without edges
  LargeBuffer<uint8_t> steps_;
  int clutter_rows_, clutter_columns_;
  std::vector<float> clutter_;
  cv::Mat ignore_;
};

/// An image edge that was found on the normal of a model edge.
struct NormalHit {
  bool found = false;
  double distance = 0;  ///< signed, pixels along the normal
  int x = 0, y = 0;     ///< the edge pixel
};

/// Searches as the paper describes, without a table. It walks from `pixel` along `normal` (unit
/// vector) to both sides in half-pixel steps, at most `length` pixels. It returns the nearest edge
/// whose direction differs from the model edge's by an angle with a cosine of at least
/// `tolerance_cos`.
NormalHit searchAlongNormal(const EdgeImage& image, const Eigen::Vector2d& pixel,
                            const Eigen::Vector2d& normal, double length, double tolerance_cos);

}  // namespace edge_mcl
