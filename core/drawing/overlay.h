/// Pictures that show what the localizer sees.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "edge_mcl/core/localization_map.h"
#include "edge_mcl/core/recordings/text_table.h"

namespace edge_mcl {

/// What of an overlay is drawn.
struct OverlayParts {
  bool model_edges = true, image_edges = true, normals = true, mask = true;
};

/// The image in the colours of the paper's figure 1: model edges green, image edges blue, the
/// normals between them red. The mask is shaded. @param scale of the picture against the image.
cv::Mat drawOverlay(const LocalizationMap& map, const PreparedImage& image, const Pose& camera_pose,
                    const OverlayParts& parts = {}, double scale = 1);

/// Perspective wireframe of the model's edges, coloured by kind, with a legend.
cv::Mat drawWireframe(const LocalizationMap& map, int width, int height);

/// Top view (x, y), side view (x, z) and position over time of an estimate, with the truth where
/// given.
cv::Mat drawTrajectories(const Trajectory& estimate, const Trajectory& truth);

}  // namespace edge_mcl
