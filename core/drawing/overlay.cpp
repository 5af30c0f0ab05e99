#include "edge_mcl/core/drawing/overlay.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "edge_mcl/core/image/edge_field.h"

namespace edge_mcl {

namespace {

const cv::Scalar kGreen(60, 200, 30), kBlue(255, 120, 30), kRed(40, 40, 235), kInk(60, 60, 60),
    kPaper(255, 255, 255), kOrange(0, 140, 240);

cv::Point toPixel(const Eigen::Vector2d& p) {
  return {static_cast<int>(std::lround(p.x())), static_cast<int>(std::lround(p.y()))};
}

cv::Scalar kindColour(EdgeKind kind) {
  // Okabe and Ito's palette: told apart by colour-blind readers, too.
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
  return kInk;
}

void label(cv::Mat* picture, const std::string& text, cv::Point at, const cv::Scalar& colour,
           double size = 0.45) {
  cv::putText(*picture, text, at, cv::FONT_HERSHEY_SIMPLEX, size, colour, 1, cv::LINE_AA);
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
  const ImageParameters& params = map.params().image;
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
  cv::Mat picture(height, width, CV_8UC3, kPaper);
  const Eigen::Vector3d low = map.mesh().lowest.cast<double>();
  const Eigen::Vector3d high = map.mesh().highest.cast<double>();
  const Eigen::Vector3d centre = (low + high) / 2;
  const double radius = std::max(1e-6, (high - low).norm() / 2);
  // Seen from above one corner, far enough that everything is in view.
  const Eigen::Vector3d back = Eigen::Vector3d(-0.6, -0.9, 0.65).normalized();
  Pose view = Pose::Identity();
  view.linear().col(2) = -back;
  view.linear().col(0) = (-back).cross(Eigen::Vector3d::UnitZ()).normalized();
  view.linear().col(1) = view.linear().col(2).cross(view.linear().col(0));
  view.translation() = centre + 3.2 * radius * back;
  const Pose view_from_map = view.inverse();
  const double focal = 1.45 * std::min(width, height);
  const auto project = [&](const Eigen::Vector3f& p) {
    const Eigen::Vector3d q = view_from_map * p.cast<double>();
    return toPixel({width / 2.0 + focal * q.x() / q.z(), height / 2.0 + focal * q.y() / q.z()});
  };
  for (const EdgeLine& line : map.edges().lines) {
    if (line.kind == EdgeKind::kContour) {
      const Eigen::Vector3f to_eye = view.translation().cast<float>() - line.start;
      if ((line.normal_a.dot(to_eye) > 0) == (line.normal_b.dot(to_eye) > 0)) continue;
    }
    cv::line(picture, project(line.start), project(line.end), kindColour(line.kind), 1,
             cv::LINE_AA);
  }
  int y = 22;
  for (int k = 0; k < kEdgeKinds; ++k) {
    const auto kind = static_cast<EdgeKind>(k);
    const size_t count = map.edges().countOf(kind);
    if (count == 0) continue;
    cv::line(picture, {12, y - 4}, {40, y - 4}, kindColour(kind), 2, cv::LINE_AA);
    label(&picture, std::string(edgeKindName(kind)) + "  " + std::to_string(count), {48, y}, kInk);
    y += 20;
  }
  char size[96];
  const Eigen::Vector3d extent = high - low;
  std::snprintf(size, sizeof size, "%.3g x %.3g x %.3g m", extent.x(), extent.y(), extent.z());
  label(&picture, size, {12, height - 12}, kInk);
  return picture;
}

namespace {

/// One panel with axes; curves are drawn in data coordinates.
class Panel {
 public:
  Panel(cv::Mat* picture, cv::Rect area, std::string title, bool equal_axes)
      : picture_(picture), area_(area), title_(std::move(title)), equal_(equal_axes) {}

  void include(double x, double y) {
    low_ = low_.cwiseMin(Eigen::Vector2d(x, y));
    high_ = high_.cwiseMax(Eigen::Vector2d(x, y));
  }
  void drawFrame() {
    if (low_.x() > high_.x()) low_ = high_ = Eigen::Vector2d::Zero();
    Eigen::Vector2d span = (high_ - low_).cwiseMax(Eigen::Vector2d(1e-3, 1e-3)) * 1.12;
    const Eigen::Vector2d room(area_.width - 70, area_.height - 60);
    if (equal_) span = room * std::max(span.x() / room.x(), span.y() / room.y());
    const Eigen::Vector2d centre = (low_ + high_) / 2;
    low_ = centre - span / 2;
    high_ = centre + span / 2;
    const cv::Rect inner(area_.x + 55, area_.y + 28, area_.width - 70, area_.height - 60);
    inner_ = inner;
    cv::rectangle(*picture_, inner, cv::Scalar(190, 190, 190), 1);
    label(picture_, title_, {inner.x, area_.y + 18}, kInk, 0.5);
    for (int k = 0; k <= 4; ++k) {
      const double fraction = k / 4.0;
      const double x = low_.x() + fraction * (high_.x() - low_.x());
      const double y = low_.y() + fraction * (high_.y() - low_.y());
      const int px = inner.x + static_cast<int>(fraction * inner.width);
      const int py = inner.y + inner.height - static_cast<int>(fraction * inner.height);
      cv::line(*picture_, {px, inner.y}, {px, inner.y + inner.height}, cv::Scalar(235, 235, 235));
      cv::line(*picture_, {inner.x, py}, {inner.x + inner.width, py}, cv::Scalar(235, 235, 235));
      char text[32];
      std::snprintf(text, sizeof text, "%.3g", x);
      label(picture_, text, {px - 14, inner.y + inner.height + 16}, kInk, 0.38);
      std::snprintf(text, sizeof text, "%.3g", y);
      label(picture_, text, {area_.x + 8, py + 4}, kInk, 0.38);
    }
  }
  void curve(const std::vector<Eigen::Vector2d>& points, const cv::Scalar& colour, int thickness) {
    std::vector<cv::Point> pixels;
    pixels.reserve(points.size());
    for (const auto& p : points)
      pixels.emplace_back(
          inner_.x + static_cast<int>((p.x() - low_.x()) / (high_.x() - low_.x()) * inner_.width),
          inner_.y + inner_.height -
              static_cast<int>((p.y() - low_.y()) / (high_.y() - low_.y()) * inner_.height));
    cv::polylines(*picture_, pixels, false, colour, thickness, cv::LINE_AA);
    for (const cv::Point& p : pixels)
      if (pixels.size() < 80) cv::circle(*picture_, p, 2, colour, cv::FILLED, cv::LINE_AA);
  }

 private:
  cv::Mat* picture_;
  cv::Rect area_, inner_;
  std::string title_;
  bool equal_;
  Eigen::Vector2d low_ = Eigen::Vector2d::Constant(1e18), high_ = Eigen::Vector2d::Constant(-1e18);
};

}  // namespace

cv::Mat drawTrajectories(const Trajectory& estimate, const Trajectory& truth) {
  cv::Mat picture(860, 1180, CV_8UC3, kPaper);
  const double start = estimate.empty() ? 0 : estimate.front().time;
  const auto coordinate = [&](const StampedPose& p, int axis) {
    return axis == 3 ? p.time - start : p.pose.translation()[axis];
  };
  struct View {
    int x, y;
    const char* title;
    cv::Rect area;
  };
  const View views[] = {{0, 1, "from above: x, y [m]", {0, 30, 590, 415}},
                        {0, 2, "from the side: x, z [m]", {590, 30, 590, 415}},
                        {3, 0, "x [m] over time [s]", {0, 445, 393, 415}},
                        {3, 1, "y [m] over time [s]", {393, 445, 393, 415}},
                        {3, 2, "z [m] over time [s]", {786, 445, 393, 415}}};
  for (const View& view : views) {
    Panel panel(&picture, view.area, view.title, view.x != 3);
    std::vector<Eigen::Vector2d> of_estimate, of_truth;
    for (const auto& p : truth) of_truth.emplace_back(coordinate(p, view.x), coordinate(p, view.y));
    for (const auto& p : estimate)
      of_estimate.emplace_back(coordinate(p, view.x), coordinate(p, view.y));
    for (const auto* list : {&of_truth, &of_estimate})
      for (const auto& p : *list) panel.include(p.x(), p.y());
    panel.drawFrame();
    panel.curve(of_truth, cv::Scalar(178, 114, 0), 3);
    panel.curve(of_estimate, kOrange, 1);
  }
  label(&picture, "estimate", {60, 22}, kOrange, 0.55);
  if (!truth.empty()) label(&picture, "reference", {160, 22}, cv::Scalar(178, 114, 0), 0.55);
  return picture;
}

}  // namespace edge_mcl
