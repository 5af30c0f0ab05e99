/// What one image shows of the model's lines.
#pragma once

#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <vector>

#include "edge_mcl/core/localization_map.h"
#include "edge_mcl/core/mesh/mesh_shapes.h"
#include "edge_mcl/core/mesh/ray_mesh.h"

namespace edge_mcl {

/// A piece of a model line (EdgeModel::segments) in one image. Counts are numbers of samples.
struct LineSight {
  uint32_t segment = 0;
  float samples = 0;     ///< in view, not masked, and not beside another part of the model
  float shown = 0;       ///< of these, with an image edge on them
  float probes = 0;      ///< places beside the line, where the model has no line
  float by_chance = 0;   ///< of these, with an image edge of the line's direction
  float on_surface = 0;  ///< depth beside the line that is that of the model's surface
  float behind = 0;      ///< depth beside the line that is farther than the model's surface
};

/// Looks at the model's lines in images. It refers to the map, which must outlive it. Safe to use
/// from several threads.
class LineSights {
 public:
  /// @throws Error when the ray caster cannot be started.
  explicit LineSights(const LocalizationMap& map);

  /// Compares one image with the model.
  /// @param depth CV_32F of the image's size, metres along the optical axis, 0: no return; empty:
  ///   none.
  std::vector<LineSight> find(const PreparedImage& image, const cv::Mat& depth,
                              const Pose& T_map_camera) const;

  /// Number of the shape that a segment belongs to (see findShapes()); -1: no face.
  int shapeOf(uint32_t segment) const { return shape_of_segment_[segment]; }
  const MeshShapes& shapes() const { return shapes_; }

 private:
  struct Sample;
  class SampleGrid;
  std::vector<Sample> samplesIn(const PreparedImage& image, const Pose& T_map_camera) const;
  void addDepth(const Sample& sample, const PreparedImage& image, const cv::Mat& depth,
                const Pose& T_map_camera, LineSight* sight) const;
  /// Whether something that is not in the model hides the sample.
  static bool isHidden(const Sample& sample, const cv::Mat& depth);

  const LocalizationMap& map_;
  MeshShapes shapes_;
  std::vector<int> shape_of_segment_;
  std::unique_ptr<RayScene> scene_;  // null: the model has no faces
};

}  // namespace edge_mcl
