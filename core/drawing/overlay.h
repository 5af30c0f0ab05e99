/// Draws an image with the projected model, and a model alone.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "edge_mcl/core/localization_map.h"

namespace edge_mcl {

/// The parts of an overlay that are drawn.
struct OverlayParts {
  bool model_edges = true, image_edges = true, normals = true, mask = true;
};

/// Draws the model over an image, in the colours of the paper's figure 1: model edges green, image
/// edges blue, the normals between them red. The mask is shaded.
/// @param camera_pose T_map_camera.
/// @param scale size of the picture relative to the image.
cv::Mat drawOverlay(const LocalizationMap& map, const PreparedImage& image, const Pose& camera_pose,
                    const OverlayParts& parts = {}, double scale = 1);

/// Draws a perspective wireframe of the model's edges, coloured by kind, with a legend.
cv::Mat drawWireframe(const LocalizationMap& map, int width, int height);

}  // namespace edge_mcl
