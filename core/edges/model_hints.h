/// Suspicions about a model that a person should look at.
#pragma once

#include <string>
#include <vector>

#include "edge_mcl/core/edges/edge_model.h"

namespace edge_mcl {

/// Sentences that name what looks wrong and the parameter that mends it: the unit, the upward axis,
/// a mirrored axis, or a scan whose edges are noise. A hint can be wrong, so nothing is changed.
/// @param edges of `mesh`.
std::vector<std::string> modelHints(const MeshModel& mesh, const EdgeModel& edges);

/// Whether a mesh looks like a scan: small triangles everywhere, and short edges in all directions.
bool looksLikeScan(const MeshModel& mesh, const EdgeModel& edges);

}  // namespace edge_mcl
