#include "edge_mcl/localization/masks/lines_under_mask.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <opencv2/imgproc.hpp>
#include <utility>

namespace edge_mcl {

std::vector<LineUnderMask> linesUnderMask(const cv::Mat& mask, const EdgePixels& edges,
                                          const VisibleSet& visible, const CameraModel& camera,
                                          const Pose& T_map_camera, double sample_step,
                                          const EdgeReach& reach) {
  cv::Mat parts;
  cv::connectedComponents(mask, parts, 8, CV_32S);
  std::map<std::pair<uint32_t, int32_t>, LineUnderMask> lines;
  const Pose camera_from_map = T_map_camera.inverse();
  // A piece that is seen nearly end-on from close by may be very long in the image. It tells
  // nothing and is left out.
  const double longest = camera.width / 8.0;
  for (const VisibleSet::Segment& segment : visible.segments) {
    const EdgeSegment& of_model = visible.edgeSegment(segment);
    const Eigen::Vector3d along =
        sample_step / 2 *
        (camera_from_map.linear() * visible.line(segment).tangent().cast<double>());
    for (uint32_t i = 0; i < EdgeSegment::kMaxSamples; ++i) {
      if (!(segment.samples >> i & 1U)) continue;
      const Eigen::Vector3d p = camera_from_map * visible.model->samplePosition(of_model, i);
      Eigen::Vector2d centre, from, to;
      if (!camera.project(p, &centre) || !camera.contains(centre)) continue;
      const int32_t part = parts.at<int32_t>(
          std::clamp(static_cast<int>(std::lround(centre.y())), 0, parts.rows - 1),
          std::clamp(static_cast<int>(std::lround(centre.x())), 0, parts.cols - 1));
      if (part == 0) continue;
      if (!camera.project(p - along, &from) || !camera.project(p + along, &to)) continue;
      const Eigen::Vector2d way = to - from;
      const double length = way.norm();
      if (length < 1e-6 || length > longest) continue;
      LineUnderMask& line = lines[{of_model.line, part}];
      line.line = of_model.line;
      line.length += length;
      line.pieces.push_back({from, to});
      const Eigen::Vector2f normal =
          Eigen::Vector2d(-way.y() / length, way.x() / length).cast<float>();
      if (edges.nearestAlong(static_cast<float>(centre.x()), static_cast<float>(centre.y()),
                             normal.x(), normal.y(), static_cast<float>(reach.pixels),
                             static_cast<float>(reach.tolerance_cos)))
        line.shown += length;
    }
  }
  std::vector<LineUnderMask> result;
  result.reserve(lines.size());
  for (auto& [key, line] : lines) result.push_back(std::move(line));
  return result;
}

void clearAlong(const LineUnderMask& line, double band, cv::Mat* mask) {
  const auto pixelAt = [](const Eigen::Vector2d& p) {
    return cv::Point(static_cast<int>(std::lround(p.x())), static_cast<int>(std::lround(p.y())));
  };
  for (const LineUnderMask::Piece& piece : line.pieces)
    cv::line(*mask, pixelAt(piece.from), pixelAt(piece.to), cv::Scalar(0),
             2 * static_cast<int>(std::ceil(band)) + 1);
}

}  // namespace edge_mcl
