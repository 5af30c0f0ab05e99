/// Table of the sample scores of one image, read by the likelihood kernels.
#pragma once

#include <cstdint>
#include <memory>

#include "edge_mcl/core/base/large_buffer.h"
#include "edge_mcl/core/base/parameters.h"
#include "edge_mcl/core/camera/camera_model.h"
#include "edge_mcl/core/image/edge_field.h"
#include "edge_mcl/core/likelihood/score_levels.h"

namespace edge_mcl {

/// Scores of one image as bytes 1..255, linear between the lowest and the highest score. 0 marks
/// ignored pixels, in every bin. The scores of a bin and of the next bin (cyclic) are stored side
/// by side, because the kernels interpolate between them. The table has one row and one column more
/// than the image, so that the kernels need not check for the border.
class ScoreTable {
 public:
  /// Makes the table. @throws InputError when it is too large, see checkSize().
  ScoreTable(const EdgeField& field, const ScoreLevels& levels);
  /// Checks the size of a table.
  /// @throws InputError when it is too large for the 32-bit offsets of the kernels.
  static void checkSize(int width, int height, int bins);

  int width() const { return width_; }
  int height() const { return height_; }
  int bins() const { return bins_; }
  /// Elements in the order (bin, y, x). Rows have stride() elements, and bins have rows() rows. Low
  /// byte: score in this bin. High byte: score in the next bin.
  const uint16_t* pairs() const { return pairs_.data(); }
  size_t pairCount() const { return pairs_.size(); }
  int stride() const { return width_ + 1; }
  int rows() const { return height_ + 1; }
  uint8_t code(int bin, int x, int y) const {
    return static_cast<uint8_t>(pairs_[(static_cast<size_t>(bin) * rows() + y) * stride() + x]);
  }
  bool hasIgnored() const { return has_ignored_; }
  /// score = offset + scale * byte.
  float scale() const { return scale_; }
  float offset() const { return offset_; }

 private:
  int width_, height_, bins_;
  bool has_ignored_;
  float scale_ = 1, offset_ = 0;
  LargeBuffer<uint16_t> pairs_;
};

}  // namespace edge_mcl
