#include "apps/mapping/mapping_source.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "edge_mcl/core/base/angles.h"
#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/image/image_edges.h"

namespace edge_mcl {

namespace {

/// Depth in metres, CV_32F.
cv::Mat metresOf(const DepthImage& depth) {
  cv::Mat metres;
  depth.depth.convertTo(metres, CV_32F,
                        depth.depth.type() == CV_16U ? 1 / depth.units_per_metre : 1);
  return metres;
}

bool isSameCamera(const CameraModel& a, const CameraModel& b, const Pose& between) {
  return a.width == b.width && a.height == b.height && std::abs(a.fx - b.fx) < 0.5 &&
         std::abs(a.fy - b.fy) < 0.5 && std::abs(a.cx - b.cx) < 0.5 &&
         std::abs(a.cy - b.cy) < 0.5 && a.distortion == b.distortion &&
         a.coefficients == b.coefficients && between.translation().norm() < 1e-3 &&
         rotationAngle(between, Pose::Identity()) < 1e-3;
}

Pose interpolate(const Pose& a, const Pose& b, double share) {
  return a * expSe3(share * logSe3(a.inverse() * b));
}

/// Depth as the camera of the image sees it. A point of the depth image covers 2 x 2 pixels, so
/// that a depth image of a lower resolution leaves no holes; the nearest point of a pixel counts.
cv::Mat registeredDepth(const DepthImage& depth, const Pose& T_camera_depth,
                        const CameraModel& camera) {
  cv::Mat metres = metresOf(depth);
  if (isSameCamera(depth.camera, camera, T_camera_depth)) return metres;
  cv::Mat result(camera.height, camera.width, CV_32F, cv::Scalar(0));
  const CameraRays rays(depth.camera);
  for (int y = 0; y < metres.rows; ++y)
    for (int x = 0; x < metres.cols; ++x) {
      const auto z = static_cast<double>(metres.at<float>(y, x));
      const Eigen::Vector2f& ray = rays.at(x, y);
      if (!(z > 0) || !std::isfinite(z) || !ray.allFinite()) continue;
      const Eigen::Vector3d point =
          T_camera_depth *
          Eigen::Vector3d(static_cast<double>(ray.x()) * z, static_cast<double>(ray.y()) * z, z);
      Eigen::Vector2d pixel;
      if (!camera.project(point, &pixel)) continue;
      const auto left = static_cast<int>(std::floor(pixel.x()));
      const auto top = static_cast<int>(std::floor(pixel.y()));
      for (int v = std::max(0, top); v <= std::min(camera.height - 1, top + 1); ++v)
        for (int u = std::max(0, left); u <= std::min(camera.width - 1, left + 1); ++u) {
          float& there = result.at<float>(v, u);
          if (there <= 0 || point.z() < static_cast<double>(there))
            there = static_cast<float>(point.z());
        }
    }
  return result;
}

}  // namespace

MappingRecording::MappingRecording(const RecordingOptions& options, const std::string& poses_file)
    : input_(openInput(options)),
      poses_(poses_file.empty() ? input_->truth() : readTrajectory(poses_file)) {
  if (poses_.empty() && !poses_file.empty())
    throw InputError(poses_file + ": there is no pose in the file");
  if (poses_.empty())
    throw InputError(options.recording +
                     ": the recording has no poses; give a trajectory with --poses, e.g. one that "
                     "edge-mcl localize has written");
  constexpr double kFar = 5000, kRound = 100;  // m, as of map.origin
  const Eigen::Vector3d first = poses_.front().pose.translation();
  if (first.cwiseAbs().maxCoeff() < kFar) return;
  origin_ = (first / kRound).array().round().matrix() * kRound;
  for (StampedPose& stamped : poses_) stamped.pose.translation() -= origin_;
}

std::optional<MappingImage> mappingImageOf(const LiveInput& input, const Pose& T_map_base) {
  if (input.images.empty() || input.depths.empty() || input.images.front().image.empty())
    return std::nullopt;
  const LiveInput::CameraImage& image = input.images.front();
  const LiveInput::Depth& depth = input.depths.front();
  MappingImage made;
  made.grey = toGrey(image.image, image.origin).clone();
  made.depth = registeredDepth(depth.image, image.T_base_camera.inverse() * depth.T_base_camera,
                               image.camera);
  if (!image.mask.empty() && image.mask.size() == made.depth.size())
    made.depth.setTo(0, image.mask);
  made.T_map_camera = T_map_base * image.T_base_camera;
  return made;
}

bool MappingRecording::next() {
  image_.reset();
  LiveInput input;
  std::string problem;
  if (!input_->next(&input, &problem)) return false;
  const std::optional<Pose> T_map_base = poseAt(poses_, input.time);
  if (!T_map_base || input.images.empty() || input.depths.empty() ||
      !gate_.take(*T_map_base * input.images.front().T_base_camera))
    return true;
  image_ = mappingImageOf(input, *T_map_base);
  if (!image_) return true;
  if (!camera_) camera_ = input.images.front().camera;
  image_->number = static_cast<uint32_t>(used_++);
  return true;
}

std::optional<Pose> poseAt(const Trajectory& poses, double time) {
  constexpr double kSameMoment = 0.01, kLongestGap = 0.2;  // s
  const auto after = std::lower_bound(poses.begin(), poses.end(), time,
                                      [](const StampedPose& p, double t) { return p.time < t; });
  if (after != poses.end() && after->time - time < kSameMoment) return after->pose;
  if (after == poses.begin()) return std::nullopt;
  const StampedPose& before = *(after - 1);
  if (time - before.time < kSameMoment) return before.pose;
  if (after == poses.end() || after->time - before.time > kLongestGap) return std::nullopt;
  return interpolate(before.pose, after->pose, (time - before.time) / (after->time - before.time));
}

bool MotionGate::take(const Pose& pose) {
  constexpr double kDistance = 0.05, kAngle = 3 * kDegree;
  if (last_ && (last_->translation() - pose.translation()).norm() <= kDistance &&
      rotationAngle(*last_, pose) <= kAngle)
    return false;
  last_ = pose;
  return true;
}

}  // namespace edge_mcl
