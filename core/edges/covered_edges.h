/// Feature edges that nobody can see because other faces cover them.
#pragma once

#include <vector>

#include "edge_mcl/core/edges/edge_model.h"

namespace edge_mcl {

/// What dropCoveredEdges() has dropped.
struct CoveredEdges {
  size_t count = 0;   ///< edges that are covered over their whole length
  double length = 0;  ///< of all covered pieces, metres
};

/// Cuts covered pieces out of the edges of a mesh. A side of a face is closed at an edge when a
/// face of the same plane (and material) goes on beyond the edge, or when another body lies on the
/// face. An edge is covered where all its sides are closed: a seam between two panels of one wall,
/// or the edge of a wall that ends at another wall. Explicit lines are left alone.
/// @param material_borders whether a border between materials is an edge.
/// @param is_shared of every edge: whether three or more faces meet at it.
/// @throws Error when the ray caster cannot be started.
CoveredEdges dropCoveredEdges(const MeshModel& mesh, bool material_borders,
                              const std::vector<bool>& is_shared, std::vector<EdgeLine>* edges);

}  // namespace edge_mcl
