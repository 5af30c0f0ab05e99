/// Thresholds of the image edges, by the contrast of the whole image and of its parts.
#pragma once

#include <cstdint>
#include <opencv2/core.hpp>
#include <vector>

#include "edge_mcl/core/base/parameters.h"

namespace edge_mcl {

/// One threshold for the whole image hides the weak edges of a dull part, when a window, a lamp or
/// a printed pattern elsewhere takes up the share of strong gradients (`image.edge_share`). So
/// every tile has a threshold of its own: the geometric mean of the image's and of the one that its
/// surroundings would have alone. It is never above that of the image and never below the noise.
class EdgeThresholds {
 public:
  /// @param gradient_x, gradient_y CV_16S, of one size. @param ignore CV_8U, 255 = ignored; may be
  /// empty. @param least lower limit of the strong threshold
  EdgeThresholds(const cv::Mat& gradient_x, const cv::Mat& gradient_y, const cv::Mat& ignore,
                 const ImageParameters& params, double least);

  /// Gradient magnitude at which an edge starts where the image has its full contrast.
  double strong() const { return strong_; }
  int tile() const { return tile_; }  ///< side, pixels, see tileOf()
  /// Squares of the thresholds of a tile, rounded down as cv::Canny does. An edge pixel has a
  /// larger squared gradient.
  struct Squares {
    int32_t weak, strong;
  };
  const Squares& at(int x, int y) const {
    return tile_ > 0 ? tiles_[indexOf(x / tile_, y / tile_)] : tiles_[0];
  }

  /// Side of a tile, pixels: a third of `image.contrast_window`, since the contrast of a tile is
  /// that of the tile and its neighbours; 0: the image has one threshold.
  static int tileOf(const ImageParameters& params);
  /// Gradients are counted by quarters of an octave of their square: by steps of 9 %.
  static constexpr int kLevels = 120;
  static int levelOf(uint32_t square);
  /// The smallest square of a level. @param level 0 to kLevels
  static uint32_t lowestOf(int level);

 private:
  size_t indexOf(int column, int row) const {
    return static_cast<size_t>(row) * static_cast<size_t>(columns_) + static_cast<size_t>(column);
  }
  Squares squaresOf(double strong, const ImageParameters& params) const;

  double strong_ = 0;
  int tile_ = 0, columns_ = 1, rows_ = 1;
  std::vector<Squares> tiles_;
};

}  // namespace edge_mcl
