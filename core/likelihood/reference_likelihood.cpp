#include "edge_mcl/core/likelihood/reference_likelihood.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace edge_mcl {

namespace {

/// A sample in the image. `direction` is the derivative of the pixel by the position along the
/// line.
struct ProjectedSample {
  bool valid = false;
  Eigen::Vector2d pixel, direction;
  double weight = 0;
};

ProjectedSample projectSample(const LikelihoodFrame& frame, const Pose& camera_from_map,
                              const Eigen::Vector3d& position, const Eigen::Vector3d& tangent) {
  ProjectedSample out;
  const Eigen::Vector3d p = camera_from_map * position;
  const Eigen::Vector3d t = camera_from_map.linear() * tangent;
  Eigen::Matrix<double, 2, 3> jacobian;
  if (!frame.camera.project(p, &out.pixel, &jacobian)) return out;
  if (!frame.camera.contains(out.pixel)) return out;
  out.direction = jacobian * t;
  const double border =
      std::min({out.pixel.x(), out.pixel.y(), frame.camera.width - 1 - out.pixel.x(),
                frame.camera.height - 1 - out.pixel.y()});
  const double fade =
      frame.params.border_fade > 0 ? std::min(1.0, border / frame.params.border_fade) : 1.0;
  // Length of the projected unit tangent (sum of both components), pixels per metre.
  const double length = std::abs(out.direction.x()) + std::abs(out.direction.y());
  const double by_depth = frame.params.model == LikelihoodModel::kPaper ? p.z() : 1;
  out.weight = fade * std::min(1.0, spacingScale(frame) * length * by_depth);
  out.valid = true;
  return out;
}

/// Score by trilinear interpolation over pixel and direction. @return false inside the mask.
bool tableScore(const ScoreTable& table, const ProjectedSample& sample, double* score) {
  const double bin = diamondAngle(sample.direction.x(), sample.direction.y()) * table.bins() / 2;
  const int bin_a = static_cast<int>(bin) % table.bins(), bin_b = (bin_a + 1) % table.bins();
  const int x = std::min(static_cast<int>(sample.pixel.x()), table.width() - 2);
  const int y = std::min(static_cast<int>(sample.pixel.y()), table.height() - 2);
  const double fx = sample.pixel.x() - x, fy = sample.pixel.y() - y, fb = bin - std::floor(bin);
  for (const int i : {0, 1, 2, 3})
    if (table.code(bin_a, x + i % 2, y + i / 2) == 0) return false;
  const auto value = [&](int b) {
    return (1 - fy) * ((1 - fx) * table.code(b, x, y) + fx * table.code(b, x + 1, y)) +
           fy * ((1 - fx) * table.code(b, x, y + 1) + fx * table.code(b, x + 1, y + 1));
  };
  *score = table.offset() + table.scale() * ((1 - fb) * value(bin_a) + fb * value(bin_b));
  return true;
}

/// Sums over the samples of one line.
struct LineSums {
  double score = 0, weight = 0;
};

/// Adds the score of a line, and how much the line counts, to the sums. Clears the line.
void closeLine(const LikelihoodParameters& params, LineSums* line, double* line_sum,
               double* line_count) {
  if (params.model == LikelihoodModel::kPaper) {
    *line_sum += line->score / std::max(1.0, line->weight);
    *line_count += std::min(1.0, line->weight);
  } else {
    *line_sum += line->score / (1 + line->weight / params.line_saturation);
    *line_count += line->weight / (line->weight + params.line_saturation);
  }
  *line = {};
}

template <class ScoreFunction>
PoseScore sumLines(const LikelihoodFrame& frame, const VisibleSet& set, const Pose& pose,
                   ScoreFunction&& score_of) {
  PoseScore out;
  const Pose camera_from_map = pose.inverse();
  LineSums line;
  double line_sum = 0, line_count = 0;
  for (size_t k = 0; k < set.segments.size(); ++k) {
    const VisibleSet::Segment& segment = set.segments[k];
    const EdgeSegment& edge = set.edgeSegment(segment);
    const Eigen::Vector3d tangent = set.line(segment).tangent().cast<double>();
    const double facing =
        frame.params.model == LikelihoodModel::kRobust ? VisibleSet::facingWeight(segment) : 1.0;
    for (uint32_t i = 0; i < edge.sample_count; ++i) {
      if (!(segment.samples >> i & 1u) || (edge.first_sample + i) % frame.thinning != 0) continue;
      const ProjectedSample s =
          projectSample(frame, camera_from_map, set.model->samplePosition(edge, i), tangent);
      double score = 0;
      if (!s.valid || !score_of(s, &score)) continue;
      line.score += facing * s.weight * score;
      line.weight += facing * s.weight;
    }
    if (set.endsGroup(k)) {
      out.sample_weight += static_cast<float>(line.weight);
      closeLine(frame.params, &line, &line_sum, &line_count);
    }
  }
  out.line_count = static_cast<float>(line_count);
  out.log_likelihood = combineLines(frame.params, line_sum, line_count);
  return out;
}

}  // namespace

PoseScore referenceScore(const LikelihoodFrame& frame, const VisibleSet& set, const Pose& pose) {
  const std::shared_ptr<const ScoreTable> table = frame.tableHere();
  return sumLines(frame, set, pose, [&](const ProjectedSample& s, double* score) {
    return tableScore(*table, s, score);
  });
}

PoseScore paperFlowScore(const LikelihoodFrame& frame, const EdgeImage& image,
                         const ImageParameters& image_params, const Visibility& visibility,
                         const Pose& pose) {
  const double tolerance = std::cos(image_params.orientation_tolerance_deg * M_PI / 180);
  const VisibleSet set = visibility.exact(pose.translation(), frame.thinning);
  return sumLines(frame, set, pose, [&](const ProjectedSample& s, double* score) {
    const int x = static_cast<int>(std::lround(s.pixel.x()));
    const int y = static_cast<int>(std::lround(s.pixel.y()));
    if (!image.ignore.empty() && image.ignore.at<uint8_t>(y, x)) return false;
    const Eigen::Vector2d direction = s.direction.normalized();
    const NormalHit hit =
        searchAlongNormal(image, s.pixel, Eigen::Vector2d(-direction.y(), direction.x()),
                          image_params.search_length, tolerance);
    *score = sampleScore(
        frame.params, hit.found ? std::abs(hit.distance) : std::numeric_limits<double>::infinity(),
        0.02, image_params.search_length);
    return true;
  });
}

}  // namespace edge_mcl
