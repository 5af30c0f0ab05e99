/// Faces of a building from depth images.
#pragma once

#include <memory>

#include "edge_mcl/core/camera/camera_model.h"
#include "edge_mcl/core/mesh/mesh_model.h"
#include "edge_mcl/mapping/depth_segments.h"

namespace edge_mcl {

struct FusionOptions {
  double voxel = 0.02;      ///< m; three voxels are the truncation distance of the field
  double max_depth = 4;     ///< m; the noise of structured light exceeds 2 cm beyond
  double face_size = 0.05;  ///< m, size of the faces after simplification
};

/// Fuses depth images into a truncated signed distance field (B. Curless, M. Levoy, "A volumetric
/// method for building complex models from range images", SIGGRAPH 1996), by Open3D.
class DepthFusion {
 public:
  /// Whether this build has Open3D.
  static bool isAvailable();
  /// @param camera of the depth images.
  /// @throws Error without Open3D.
  DepthFusion(const CameraModel& camera, const FusionOptions& options);
  ~DepthFusion();

  /// Adds the depth of an image.
  void add(const MappingImage& image);
  /// The surface as simplified faces, map frame. Empty when nothing was seen.
  MeshSoup faces() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace edge_mcl
