#include "edge_mcl/core/likelihood/score_table.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <limits>
#include <string>
#include <vector>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/image/table_kernel.h"

namespace edge_mcl {

namespace {

constexpr int kCell = EdgeField::kClutterCell;
static_assert(kCell == 8, "lookUpByCell works on eight pixels");

}  // namespace

void ScoreTable::checkSize(int width, int height, int bins) {
  const double bytes = 2.0 * bins * (height + 1.0) * (width + 1.0);
  if (bytes >= std::numeric_limits<int32_t>::max())
    throw InputError("an image of " + std::to_string(width) + "x" + std::to_string(height) +
                     " pixels is too large for " + std::to_string(bins) +
                     " directions (image.orientation_bins): reduce one of them");
}

ScoreTable::ScoreTable(const EdgeField& field, const ScoreLevels& levels)
    : width_(field.width()),
      height_(field.height()),
      bins_(field.bins()),
      has_ignored_(!field.ignore().empty()),
      scale_(levels.scale()),
      offset_(levels.offset()),
      // One more element, because the kernels read two neighbours at once, also beyond the last
      // column.
      pairs_(static_cast<size_t>(bins_) * rows() * stride() + 1) {
  checkSize(width_, height_, bins_);
  const size_t plane = static_cast<size_t>(rows()) * stride();
  pairs_[bins_ * plane] = 0;
  // Eight rows share their densities of clutter. All bins of a row are done together, so that they
  // stay in the caches.
  tbb::parallel_for(0, (height_ + kCell - 1) / kCell, [&](int cell_row) {
    const size_t cells = (static_cast<size_t>(width_) + kCell - 1) / kCell;
    std::vector<const uint8_t*> codes_of_cell(bins_ * cells);
    for (int b = 0; b < bins_; ++b)
      for (size_t c = 0; c < cells; ++c)
        codes_of_cell[b * cells + c] =
            levels.codes(b, field.clutter(b, static_cast<int>(c) * kCell, cell_row * kCell));
    const size_t padded = cells * kCell + 1;
    std::vector<uint8_t> codes(bins_ * padded);
    for (int y = cell_row * kCell; y < std::min(height_, (cell_row + 1) * kCell); ++y) {
      for (int b = 0; b < bins_; ++b) {
        uint8_t* row = &codes[b * padded];
        lookUpByCell(field.steps(b) + y * field.stepsStride(), &codes_of_cell[b * cells],
                     levels.entries(), cells, row);
        if (has_ignored_) {
          const uint8_t* ignored = field.ignore().ptr<uint8_t>(y);
          for (int x = 0; x < width_; ++x)
            if (ignored[x]) row[x] = 0;
        }
        row[width_] = row[width_ - 1];
      }
      for (int b = 0; b < bins_; ++b) {
        const uint8_t *here = &codes[b * padded], *next = &codes[(b + 1) % bins_ * padded];
        uint16_t* out = &pairs_[b * plane + static_cast<size_t>(y) * stride()];
        interleaveRow(here, next, stride(), out);
        if (y == height_ - 1) std::copy(out, out + stride(), out + stride());
      }
    }
  });
}

}  // namespace edge_mcl
