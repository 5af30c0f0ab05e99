/// Makes the score table from the edges of every direction bin: distances along normals, codes,
/// elements of the table. The functions are the bodies of the kernels, for host and device, see
/// picture_math.h.
#pragma once

#include "edge_mcl/gpu/math/picture_math.h"

namespace edge_mcl::gpu {

/// A pixel line: pixels along which the normals of a bin are walked. `row` numbers its pixels. In a
/// transposed bin `row` is the column of the image, and `column` is the row of the image.
struct DigitalLine {
  int32_t bin, turned, rows, columns;
  int32_t start;         ///< column at row 0; may lie outside of the image
  const int32_t* shift;  ///< column minus `start`, by row
};

/// Returns the pixel line of a bin that has the given column in the given row.
EDGE_MCL_DEVICE_FUNCTION DigitalLine lineThrough(const PictureWork& w, int bin, int row,
                                                 int column) {
  const bool turned = w.direction[bin].transposed;
  const int32_t* shift = w.shift + bin * w.longest;
  return {
      bin,  turned, turned ? w.width : w.height, turned ? w.height : w.width, column - shift[row],
      shift};
}

/// A pixel of a pixel line.
struct LinePixel {
  int32_t x, y;
  bool inside;  ///< whether it lies in the image
};

/// Returns the pixel of a pixel line in a row.
EDGE_MCL_DEVICE_FUNCTION LinePixel pixelOf(const DigitalLine& line, int row) {
  if (row < 0 || row >= line.rows) return {0, 0, false};
  const int column = line.start + line.shift[row];
  const bool inside = column >= 0 && column < line.columns;
  return line.turned ? LinePixel{row, column, inside} : LinePixel{column, row, inside};
}

/// Whether the pixel of a pixel line in a row is a hit of its bin, see PictureWork::hit.
EDGE_MCL_DEVICE_FUNCTION bool isHit(const PictureWork& w, const DigitalLine& line, int row) {
  const LinePixel p = pixelOf(line, row);
  return p.inside && (w.hit[p.y * w.width + p.x] >> line.bin & 1u);
}

/// Returns how many words before and behind a word hold all edges in reach.
EDGE_MCL_DEVICE_FUNCTION int reachOf(int no_edge) { return (no_edge + kWord - 2) / kWord; }

/// Returns the number of steps to the nearest hit, or `no_edge` when no hit is nearer.
/// @param word hits of the word with pixel `i`, with `reach` words before and behind.
EDGE_MCL_DEVICE_FUNCTION int nearestStep(const uint32_t* word, int reach, int i, int no_edge) {
  int steps = no_edge, steps_ahead = no_edge;
  const uint32_t back = word[0] & (0xffffffffu >> (kWord - 1 - i));
  if (back) {
    steps = i - (kWord - 1 - leadingZeros(back));
  } else {
    for (int k = 1; k <= reach; ++k)
      if (word[-k]) {
        steps = i + kWord * k - (kWord - 1 - leadingZeros(word[-k]));
        break;
      }
  }
  const uint32_t ahead = word[0] & (0xffffffffu << i);
  if (ahead) {
    steps_ahead = trailingZeros(ahead) - i;
  } else {
    for (int k = 1; k <= reach; ++k)
      if (word[k]) {
        steps_ahead = kWord * k + trailingZeros(word[k]) - i;
        break;
      }
  }
  if (steps_ahead < steps) steps = steps_ahead;
  return steps < no_edge ? steps : no_edge;
}

/// Sets the code of a pixel that is `steps` steps away from an edge; 0 when the pixel is ignored.
EDGE_MCL_DEVICE_FUNCTION void codePixel(const PictureWork& w, int bin, const LinePixel& p,
                                        int steps) {
  const int cell = (p.y >> 3) * w.cell_columns + (p.x >> 3);
  static_assert(kClutterCell == 8, "as shifts");
  const int level = w.level[bin * w.cell_columns * w.cell_rows + cell];
  const uint8_t code = w.level_codes[(bin * w.levels + level) * w.entries + steps];
  const int32_t at = p.y * w.width + p.x;
  w.codes[static_cast<int64_t>(bin) * w.width * w.height + at] =
      w.ignore && w.ignore[at] ? uint8_t{0} : code;
}

/// Sets the elements of the table for one pixel, in all bins.
EDGE_MCL_DEVICE_FUNCTION void quadUp(const PictureWork& w, int x, int y) {
  const int64_t plane = static_cast<int64_t>(w.width) * w.height;
  const int32_t at = y * w.width + x;
  const int32_t right = x + 1 < w.width ? 1 : 0, below = y + 1 < w.height ? w.width : 0;
  const auto codes = [&](int bin) {
    const uint8_t* c = w.codes + bin * plane + at;
    return Quad{c[0] | static_cast<uint32_t>(c[right]) << 16,
                c[below] | static_cast<uint32_t>(c[below + right]) << 16};
  };
  const Quad first = codes(0);
  Quad here = first;
  for (int bin = 0; bin < w.bins; ++bin) {
    const Quad next = bin + 1 < w.bins ? codes(bin + 1) : first;
    w.quads[bin * plane + at] = {here.top | next.top << 8, here.bottom | next.bottom << 8};
    here = next;
  }
}

/// Sets one element of the table from ScoreTable::pairs of the host.
EDGE_MCL_DEVICE_FUNCTION void quadOfPairs(const Table& table, const uint16_t* pairs, int bin, int x,
                                          int y, Quad* quads) {
  const int64_t stride = table.width + 1;
  const uint16_t* p = pairs + (bin * (table.height + int64_t{1}) + y) * stride + x;
  quads[(static_cast<int64_t>(bin) * table.height + y) * table.width + x] = {
      p[0] | static_cast<uint32_t>(p[1]) << 16, p[stride] | static_cast<uint32_t>(p[stride + 1])
                                                                << 16};
}

}  // namespace edge_mcl::gpu
