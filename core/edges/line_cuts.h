/// Cuts pieces out of lines.
#pragma once

#include <array>
#include <vector>

#include "edge_mcl/core/edges/edge_model.h"

namespace edge_mcl {

/// Cuts the pieces out of the lines that they lie on. Pieces that lie on no line are ignored.
/// @param pieces start and end of each, map frame, metres.
/// @return number of pieces that lie on a line
size_t cutOut(const std::vector<std::array<Eigen::Vector3d, 2>>& pieces,
              std::vector<EdgeLine>* lines);

}  // namespace edge_mcl
