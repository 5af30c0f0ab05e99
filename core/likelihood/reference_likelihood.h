/// Slow, plain, double-precision versions of the measurement model, written for reading. They
/// are the truth that the fast backends are tested against, and the "CPU flow" of the paper's
/// figure 2 for the benchmark.
#pragma once

#include "edge_mcl/core/likelihood/likelihood_backend.h"

namespace edge_mcl {

/// The model over a given visible set and table.
PoseScore referenceScore(const LikelihoodFrame& frame, const VisibleSet& set, const Pose& pose);

/// The flow of figure 2 for one particle: exact hidden-line removal for its position, projection,
/// search along every normal, equations (1) to (3). No table, no cache.
PoseScore paperFlowScore(const LikelihoodFrame& frame, const EdgeImage& image,
                         const ImageParameters& image_params, const Visibility& visibility,
                         const Pose& pose);

}  // namespace edge_mcl
