#include "edge_mcl/mapping/depth_fusion.h"

#ifdef EDGE_MCL_HAS_OPEN3D
#include <omp.h>
#include <open3d/camera/PinholeCameraIntrinsic.h>
#include <open3d/geometry/Image.h>
#include <open3d/geometry/RGBDImage.h>
#include <open3d/geometry/TriangleMesh.h>
#include <open3d/pipelines/integration/ScalableTSDFVolume.h>
#endif

#include <cmath>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/mapping/face_simplification.h"

namespace edge_mcl {

#ifdef EDGE_MCL_HAS_OPEN3D

struct DepthFusion::Impl {
  Impl(const CameraModel& c, const FusionOptions& o)
      : options(o),
        intrinsic(c.width, c.height, c.fx, c.fy, c.cx, c.cy),
        volume(o.voxel, 3 * o.voxel, open3d::pipelines::integration::TSDFVolumeColorType::NoColor) {
  }
  FusionOptions options;
  open3d::camera::PinholeCameraIntrinsic intrinsic;
  open3d::pipelines::integration::ScalableTSDFVolume volume;
};

bool DepthFusion::isAvailable() { return true; }

DepthFusion::DepthFusion(const CameraModel& camera, const FusionOptions& options)
    : impl_(std::make_unique<Impl>(camera, options)) {}

void DepthFusion::add(const MappingImage& image) {
  open3d::geometry::RGBDImage rgbd;
  rgbd.depth_.Prepare(image.depth.cols, image.depth.rows, 1, sizeof(float));
  for (int y = 0; y < image.depth.rows; ++y)
    for (int x = 0; x < image.depth.cols; ++x) {
      const float z = image.depth.at<float>(y, x);
      *rgbd.depth_.PointerAt<float>(x, y) =
          std::isfinite(z) && static_cast<double>(z) < impl_->options.max_depth ? z : 0;
    }
  // Open3D starts all threads of OpenMP for each block of 16 x 16 x 16 voxels. They spin while they
  // wait for one another. On an idle machine this gains nothing, and beside other programs the
  // threads wait for most of the time.
  omp_set_num_threads(1);
  impl_->volume.Integrate(rgbd, impl_->intrinsic, image.T_map_camera.inverse().matrix());
}

MeshSoup DepthFusion::faces() const {
  const auto mesh = impl_->volume.ExtractTriangleMesh();
  std::vector<Eigen::Vector3f> vertices;
  for (const Eigen::Vector3d& v : mesh->vertices_) vertices.push_back(v.cast<float>());
  std::vector<std::array<uint32_t, 3>> triangles;
  for (const Eigen::Vector3i& t : mesh->triangles_)
    triangles.push_back(
        {static_cast<uint32_t>(t.x()), static_cast<uint32_t>(t.y()), static_cast<uint32_t>(t.z())});
  return simplifiedFaces(vertices, triangles, impl_->options.face_size);
}

#else

struct DepthFusion::Impl {};

bool DepthFusion::isAvailable() { return false; }

DepthFusion::DepthFusion(const CameraModel& /*camera*/, const FusionOptions& /*options*/) {
  throw Error("this build has no Open3D, which fuses depth images");
}

void DepthFusion::add(const MappingImage& /*image*/) {}

MeshSoup DepthFusion::faces() const { return {}; }

#endif

DepthFusion::~DepthFusion() = default;

}  // namespace edge_mcl
