/// Compares the long contours of an image with the visible model edges of a pose, in both
/// directions. The likelihood itself goes from the model to the image only.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "edge_mcl/core/base/se3.h"
#include "edge_mcl/core/camera/camera_model.h"
#include "edge_mcl/core/edges/visibility.h"
#include "edge_mcl/core/image/image_edges.h"

namespace edge_mcl {

/// Result of a comparison of image and model: numbers of pixels.
struct ContourMatch {
  /// Contour pixels of the image that are near a visible model edge of the same direction.
  size_t explained = 0;
  /// Pixels of visible model edges that have no image edge of the same direction near them.
  size_t missing = 0;
};

/// The long contours of one image. They are compared with the model edges that are visible from a
/// pose. Every pixel counts once, even where many model lines lie upon each other. A pose without
/// visible model edges explains nothing.
class ImageContours {
 public:
  /// Takes the connected edges that are long enough. An edge is taken for noise when both its width
  /// and its height are below a limit: 32 pixels or a twentieth of the image's width, whichever is
  /// larger.
  explicit ImageContours(const EdgeImage& image);

  /// Number of pixels of the long contours.
  size_t size() const { return pixels_.size(); }

  /// Compares the contours with the model at a camera pose. Near means within about 1 % of the
  /// image's width. The same direction means within about 30 degrees. Model edges under the mask
  /// are never missing. @param visible set from about the position of the camera.
  /// @param sample_step distance between the samples of the set, metres.
  ContourMatch compare(const VisibleSet& visible, const CameraModel& camera,
                       const Pose& T_map_camera, double sample_step) const;

 private:
  /// Grid over the image. Its cells are squares of a few pixels. A byte has one bit for each of
  /// eight directions. A margin of one cell around the image saves the checks for neighbours.
  using Cells = std::vector<uint8_t>;
  struct Pixel {
    uint32_t cell = 0;
    uint8_t direction = 0;  ///< one bit is set
  };
  size_t cellAt(int x, int y) const;
  /// Sets direction bits in a cell and its eight neighbours.
  void paintAround(size_t cell, uint8_t directions, Cells* cells) const;
  /// Fills image_edges_.
  void paintEdges(const EdgeImage& image);

  int cell_ = 1, columns_ = 0, rows_ = 0;  ///< side of a cell in pixels; size in cells
  size_t stride_ = 0;
  std::vector<Pixel> pixels_;
  Cells image_edges_;  ///< directions of model edges that have an image edge here, or a mask
};

/// Whether the long contours of an image have at least as many pixels as the image is wide: about a
/// line from border to border. A bare wall shows less.
bool showsLongContours(const EdgeImage& image);

}  // namespace edge_mcl
