/// How much of what an image shows a pose explains: the other direction of the likelihood, which
/// asks of what the model shows.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "edge_mcl/core/camera_model.h"
#include "edge_mcl/core/image_edges.h"
#include "edge_mcl/core/se3.h"
#include "edge_mcl/core/visibility.h"

namespace edge_mcl {

/// The edges of one image that are long enough to be of something, and whether a view of the model
/// has edges of their direction there. Every pixel counts once, however many lines of the model
/// lie upon each other, and a pose that has nothing in view explains nothing.
class ImageContours {
 public:
  /// Connected edges whose width and height are below 32 pixels or a twentieth of the image's width
  /// are taken for noise.
  explicit ImageContours(const EdgeImage& image);

  /// Pixels, all of them.
  size_t size() const { return pixels_.size(); }

  /// Pixels near (about 1 % of the image's width) a visible model edge of their direction (within
  /// some 30 degrees).
  /// @param visible from about the camera's position. @param sample_step metres between samples of
  /// the set.
  size_t explainedBy(const VisibleSet& visible, const CameraModel& camera, const Pose& T_map_camera,
                     double sample_step) const;

 private:
  /// Cells of a few pixels; a bit for each of eight directions.
  struct Pixel {
    uint32_t cell = 0;
    uint8_t direction = 0;  ///< one bit
  };
  int cell_ = 1, columns_ = 0, rows_ = 0;
  std::vector<Pixel> pixels_;
};

}  // namespace edge_mcl
