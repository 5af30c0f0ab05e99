#include "edge_mcl/core/drawing/overlay.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "edge_mcl/core/drawing/chart.h"
#include "edge_mcl/core/drawing/line_view.h"
#include "edge_mcl/core/image/edge_field.h"
#include "edge_mcl/core/image/pixel_scale.h"

namespace edge_mcl {

namespace {

const cv::Scalar kGreen(60, 200, 30), kBlue(255, 120, 30), kRed(40, 40, 235);

cv::Point toPixel(const Eigen::Vector2d& p) {
  return {static_cast<int>(std::lround(p.x())), static_cast<int>(std::lround(p.y()))};
}

cv::Scalar kindColour(EdgeKind kind) {
  // Okabe and Ito's palette: colour-blind readers can tell its colours apart, too.
  switch (kind) {
    case EdgeKind::kCrease:
      return {178, 114, 0};
    case EdgeKind::kBoundary:
      return {0, 94, 213};
    case EdgeKind::kMaterial:
      return {167, 121, 204};
    case EdgeKind::kLine:
      return {115, 158, 0};
    case EdgeKind::kContour:
      return {0, 159, 230};
  }
  return chartInk();
}

}  // namespace

cv::Mat drawOverlay(const LocalizationMap& map, const PreparedImage& image, const Pose& camera_pose,
                    const OverlayParts& parts, double scale) {
  const auto enlarged = [&](const cv::Mat& pixels, int interpolation) {
    cv::Mat result;
    if (scale == 1)
      result = pixels;
    else
      cv::resize(pixels, result, {}, scale, scale, interpolation);
    return result;
  };
  cv::Mat picture;
  cv::cvtColor(enlarged(image.edges.grey, cv::INTER_LINEAR), picture, cv::COLOR_GRAY2BGR);
  picture = picture * 0.6 + cv::Scalar(50, 50, 50);
  if (parts.mask && !image.edges.ignore.empty())
    cv::add(picture, cv::Scalar(60, 0, 60), picture,
            enlarged(image.edges.ignore, cv::INTER_NEAREST));
  if (parts.image_edges) picture.setTo(kBlue, enlarged(image.edges.edges, cv::INTER_NEAREST));
  if (!parts.model_edges && !parts.normals) return picture;

  // The centre of the top-left pixel is (0, 0).
  const auto at = [&](const Eigen::Vector2d& p) {
    return toPixel((p + Eigen::Vector2d(0.5, 0.5)) * scale - Eigen::Vector2d(0.5, 0.5));
  };
  const CameraModel& camera = image.frame.camera;
  const VisibleSet set = map.visibility().exact(camera_pose.translation());
  const Pose camera_from_map = camera_pose.inverse();
  const ImageParameters params = scaledBy(image.pixel_scale, map.params().image);
  const double tolerance = std::cos(params.orientation_tolerance_deg * M_PI / 180);
  const float half_step = static_cast<float>(map.edges().sample_step) / 2;
  int counter = 0;
  for (const VisibleSet::Segment& segment : set.segments)
    for (uint32_t i = 0; i < EdgeSegment::kMaxSamples; ++i) {
      if (!(segment.samples >> i & 1u)) continue;
      Eigen::Vector2d pixel, from, to;
      Eigen::Matrix<double, 2, 3> jacobian;
      const Eigen::Vector3d p =
          camera_from_map * map.edges().samplePosition(set.edgeSegment(segment), i);
      const Eigen::Vector3d t =
          camera_from_map.linear() * set.line(segment).tangent().cast<double>();
      if (!camera.project(p, &pixel, &jacobian) || !camera.contains(pixel)) continue;
      if (parts.model_edges && camera.project(p - half_step * t, &from) &&
          camera.project(p + half_step * t, &to) && camera.contains(from) && camera.contains(to))
        cv::line(picture, at(from), at(to), kGreen, 1, cv::LINE_AA);
      if (counter++ % 3 != 0 || !parts.normals) continue;
      const Eigen::Vector2d direction = (jacobian * t).normalized();
      const Eigen::Vector2d normal(-direction.y(), direction.x());
      const NormalHit hit =
          searchAlongNormal(image.edges, pixel, normal, params.search_length, tolerance);
      if (hit.found && std::abs(hit.distance) >= 1)
        cv::line(picture, at(pixel), at(pixel + hit.distance * normal), kRed, 1, cv::LINE_AA);
    }
  return picture;
}

cv::Mat drawWireframe(const LocalizationMap& map, int width, int height) {
  const DrawnBox box{map.mesh().lowest.cast<double>(), map.mesh().highest.cast<double>()};
  std::vector<DrawnLine> lines;
  for (const EdgeLine& line : map.edges().lines) {
    if (line.kind == EdgeKind::kContour) {
      const Eigen::Vector3f to_eye = box.eye().cast<float>() - line.start;
      if ((line.normal_a.dot(to_eye) > 0) == (line.normal_b.dot(to_eye) > 0)) continue;
    }
    lines.push_back({line.start.cast<double>(), line.end.cast<double>(), kindColour(line.kind)});
  }
  std::vector<LegendEntry> legend;
  for (int k = 0; k < kEdgeKinds; ++k) {
    const auto kind = static_cast<EdgeKind>(k);
    const size_t count = map.edges().countOf(kind);
    if (count > 0)
      legend.push_back(
          {std::string(edgeKindName(kind)) + "  " + std::to_string(count), kindColour(kind)});
  }
  return drawLineView(lines, box, legend, {width, height});
}

}  // namespace edge_mcl
