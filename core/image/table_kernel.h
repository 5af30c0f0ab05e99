/// Vectorised functions for the rows of per-image tables. Internal.
#pragma once

#include <cstddef>
#include <cstdint>

namespace edge_mcl {

/// Computes target = min(target, min(source + 1, none)), element by element.
/// @param none at most 254.
void relaxRow(const uint8_t* source, uint8_t none, uint8_t* target, size_t count);

/// Looks up every element in the table of its cell of eight elements:
/// out[i] = table_of_cell[i / 8][in[i]].
/// @param entries number of entries of every table. The memory of a table holds at least 32
///   entries.
/// @param cells number of cells. Eight elements are read and written for each cell.
void lookUpByCell(const uint8_t* in, const uint8_t* const* table_of_cell, size_t entries,
                  size_t cells, uint8_t* out);

/// Interleaves two rows: out[i] = low[i] | high[i] << 8.
void interleaveRow(const uint8_t* low, const uint8_t* high, size_t count, uint16_t* out);

}  // namespace edge_mcl
