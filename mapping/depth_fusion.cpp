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
#include <opencv2/imgproc.hpp>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/mapping/face_simplification.h"

namespace edge_mcl {

#ifdef EDGE_MCL_HAS_OPEN3D

struct DepthFusion::Impl {
  Impl(const CameraModel& c, const FusionOptions& o)
      : options(o),
        intrinsic(c.width, c.height, c.fx, c.fy, c.cx, c.cy),
        volume(o.voxel, 3 * o.voxel, open3d::pipelines::integration::TSDFVolumeColorType::NoColor) {
    if (c.distortion != DistortionModel::kNone) findOrigins(c);
  }

  /// Open3D knows no distortion. So it gets the depth of a camera that has none.
  cv::Mat straightened(const cv::Mat& depth) const {
    if (origins_x.empty() || depth.size() != origins_x.size()) return depth;
    cv::Mat result;
    // Between two surfaces there is none, so depths must not be mixed.
    cv::remap(depth, result, origins_x, origins_y, cv::INTER_NEAREST, cv::BORDER_CONSTANT);
    return result;
  }

  FusionOptions options;
  open3d::camera::PinholeCameraIntrinsic intrinsic;
  open3d::pipelines::integration::ScalableTSDFVolume volume;

 private:
  void findOrigins(const CameraModel& c) {
    origins_x = cv::Mat(c.height, c.width, CV_32F, cv::Scalar(-1));
    origins_y = origins_x.clone();
    for (int y = 0; y < c.height; ++y)
      for (int x = 0; x < c.width; ++x) {
        Eigen::Vector2d pixel;
        if (!c.project({(x - c.cx) / c.fx, (y - c.cy) / c.fy, 1}, &pixel)) continue;
        origins_x.at<float>(y, x) = static_cast<float>(pixel.x());
        origins_y.at<float>(y, x) = static_cast<float>(pixel.y());
      }
  }

  cv::Mat origins_x, origins_y;  // pixel of the distorted image for every pixel without distortion
};

bool DepthFusion::isAvailable() { return true; }

DepthFusion::DepthFusion(const CameraModel& camera, const FusionOptions& options)
    : impl_(std::make_unique<Impl>(camera, options)) {}

void DepthFusion::add(const MappingImage& image) {
  open3d::geometry::RGBDImage rgbd;
  const cv::Mat depth = impl_->straightened(image.depth);
  rgbd.depth_.Prepare(depth.cols, depth.rows, 1, sizeof(float));
  for (int y = 0; y < depth.rows; ++y)
    for (int x = 0; x < depth.cols; ++x) {
      const float z = depth.at<float>(y, x);
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
