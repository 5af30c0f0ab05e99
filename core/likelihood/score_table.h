/// Per-image table of sample scores, read by the likelihood kernels.
#pragma once

#include <cstdint>
#include <memory>

#include "edge_mcl/core/base/large_buffer.h"
#include "edge_mcl/core/base/parameters.h"
#include "edge_mcl/core/camera/camera_model.h"
#include "edge_mcl/core/image/edge_field.h"
#include "edge_mcl/core/likelihood/score_levels.h"

namespace edge_mcl {

/// Scores as bytes, 1..255 linear between lowest and highest score; 0 marks ignored pixels, in
/// every bin. A bin and the next one (cyclic) are stored side by side, as the kernels interpolate
/// between them; a row and a column more than the image has spare them the border.
class ScoreTable {
 public:
  /// @throws InputError, see checkSize.
  ScoreTable(const EdgeField& field, const ScoreLevels& levels);
  /// @throws InputError where the table would be too large for the kernels' 32-bit offsets.
  static void checkSize(int width, int height, int bins);

  int width() const { return width_; }
  int height() const { return height_; }
  int bins() const { return bins_; }
  /// Row-major (bin, y, x), rows of stride() elements, bins of rows() rows; low byte: score in this
  /// bin, high byte: score in the next.
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
