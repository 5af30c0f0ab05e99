/// Joining of collinear, touching or overlapping straight pieces.
#pragma once

#include <cstddef>
#include <vector>

#include "edge_mcl/core/edges/edge_model.h"

namespace edge_mcl {

/// Replaces pieces that lie on one straight line and touch or overlap by their union. Only
/// start, end and kind are used; the longest piece decides the kind.
/// @param tolerance metres: largest distance between "the same" lines and largest gap.
/// @return number of pieces that disappeared.
size_t mergeCollinear(std::vector<EdgeLine>* lines, double tolerance);

/// Numbers the groups: lines that continue each other with a turn of less than 35 degrees are
/// pieces of one curve (the rim of a round column) and share a group. Orders lines by group.
/// @return number of groups.
uint32_t groupCurves(std::vector<EdgeLine>* lines, double tolerance);

}  // namespace edge_mcl
