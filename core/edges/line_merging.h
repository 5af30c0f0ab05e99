/// Joining of straight edges to lines, and of lines to curves.
#pragma once

#include <cstddef>
#include <vector>

#include "edge_mcl/core/edges/edge_model.h"

namespace edge_mcl {

/// Replaces pieces that lie on one straight line and touch or overlap by their union. The union
/// takes its kind and faces from the longest piece.
/// @param tolerance metres: largest distance between lines that count as one, and largest gap.
/// @return number of pieces that disappeared.
size_t mergeCollinear(std::vector<EdgeLine>* lines, double tolerance);

/// Puts the lines of a curve into one group, and numbers the groups. A curve goes on from one line
/// to the next with a turn of at most 35 degrees (the rim of a round column). Lines are ordered by
/// group.
/// @param tolerance metres; line ends within one cell of 4 tolerances meet.
/// @return number of groups.
uint32_t groupCurves(std::vector<EdgeLine>* lines, double tolerance);

}  // namespace edge_mcl
