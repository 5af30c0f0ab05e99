/// Slow and plain versions of the measurement model in double precision, written for reading. The
/// fast backends are tested against them. The benchmark uses paperFlowScore() as the "CPU flow" of
/// the paper's figure 2.
#pragma once

#include "edge_mcl/core/likelihood/likelihood_backend.h"

namespace edge_mcl {

/// Scores a pose (T_map_camera) with a given visible set and the table of the frame.
PoseScore referenceScore(const LikelihoodFrame& frame, const VisibleSet& set, const Pose& pose);

/// Scores a pose (T_map_camera) by the flow of the paper's figure 2: exact hidden-line removal at
/// its position, projection, search along every normal, equations (1) to (3). It uses no table and
/// no cache.
PoseScore paperFlowScore(const LikelihoodFrame& frame, const EdgeImage& image,
                         const ImageParameters& image_params, const Visibility& visibility,
                         const Pose& pose);

}  // namespace edge_mcl
