/// How much of what an image shows a pose explains: the other direction of the likelihood, which
/// asks of what the model shows.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "edge_mcl/core/base/se3.h"
#include "edge_mcl/core/camera/camera_model.h"
#include "edge_mcl/core/edges/visibility.h"
#include "edge_mcl/core/image/image_edges.h"

namespace edge_mcl {

/// What a view of the model has in common with an image, in pixels.
struct ContourMatch {
  size_t explained = 0;  ///< of the image's contours: near a visible model edge of their direction
  size_t missing = 0;    ///< of the model's visible edges: no image edge of their direction is near
};

/// The edges of one image that are long enough to be of something, and whether a view of the model
/// has edges of their direction there, and the other way round. Every pixel counts once, however
/// many lines of the model lie upon each other. A pose that has nothing in view explains nothing.
class ImageContours {
 public:
  /// Connected edges whose width and height are below 32 pixels or a twentieth of the image's width
  /// are taken for noise.
  explicit ImageContours(const EdgeImage& image);

  /// Pixels, all of them.
  size_t size() const { return pixels_.size(); }

  /// Near: about 1 % of the image's width; of a direction: within some 30 degrees. Under the mask
  /// nothing is missing.
  /// @param visible from about the camera's position. @param sample_step metres between samples of
  /// the set.
  ContourMatch compare(const VisibleSet& visible, const CameraModel& camera,
                       const Pose& T_map_camera, double sample_step) const;

 private:
  /// Cells of a few pixels, with a margin of one cell around the image, so that neighbours need no
  /// checks; a bit for each of eight directions.
  using Cells = std::vector<uint8_t>;
  struct Pixel {
    uint32_t cell = 0;
    uint8_t direction = 0;  ///< one bit
  };
  size_t cellAt(int x, int y) const;
  void paintAround(size_t cell, uint8_t directions, Cells* cells) const;
  void paintEdges(const EdgeImage& image);

  int cell_ = 1, columns_ = 0, rows_ = 0;
  size_t stride_ = 0;
  std::vector<Pixel> pixels_;
  Cells image_edges_;  ///< where model edges of these directions find one, or a mask
};

}  // namespace edge_mcl
