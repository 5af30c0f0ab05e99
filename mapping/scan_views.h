/// Views of a scan from inside, as images whose edges are those of its surfaces.
#pragma once

#include <memory>
#include <vector>

#include "edge_mcl/core/camera/camera_rays.h"
#include "edge_mcl/core/mesh/ray_mesh.h"
#include "edge_mcl/mapping/depth_segments.h"
#include "edge_mcl/mapping/scan_places.h"

namespace edge_mcl {

/// Renders a scan. The colour of a pixel is the direction that the surface faces, so that creases
/// are edges and the texture of the scan is not. The mean over the images of many places leaves the
/// edges that all of them show, and the noise of the scan averages out.
class ScanViews {
 public:
  /// @param mesh must outlive this object. @throws Error when the ray caster cannot be started.
  explicit ScanViews(const MeshModel& mesh);

  /// A camera inside the scan that sees its front sides.
  struct View {
    Pose T_map_camera = Pose::Identity();
    uint32_t place = 0;  ///< views with the same number are from one place
  };
  /// Views all around from each place, in a fixed order.
  std::vector<View> views(const ScanPlaces& wanted) const;
  const CameraModel& camera() const { return camera_; }

  /// Renders one view: an image for each axis that surfaces may face, and one for steps of depth.
  /// All have the same depth, and the place as their number: what several views from one place
  /// agree on may be an outline that only this place sees.
  std::vector<MappingImage> render(const View& view) const;

 private:
  /// What the ray of a pixel meets.
  struct Surface {
    float distance = 0;  // 0: nothing, or the back of a surface
    Eigen::Vector3f normal = Eigen::Vector3f::Zero();
  };
  Surface surfaceAt(const Eigen::Vector3f& from, const Eigen::Vector3f& direction) const;
  /// Front sides in all directions.
  std::vector<SurfacePiece> frontsFrom(const Eigen::Vector3d& place) const;

  const MeshModel& mesh_;
  RayScene scene_;
  std::vector<Eigen::Vector3f> vertex_normals_;
  CameraModel camera_;
  std::unique_ptr<CameraRays> rays_;
};

}  // namespace edge_mcl
