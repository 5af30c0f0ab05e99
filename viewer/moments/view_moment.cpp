#include "edge_mcl/viewer/moments/view_moment.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/depth/depth_points.h"
#include "edge_mcl/core/image/eight_bits.h"

namespace edge_mcl {

const char* UpdateTimes::name(size_t stage) {
  static const char* const kNames[kStages] = {"edges", "table", "likelihood", "refinement",
                                              "search"};
  return kNames[stage];
}

cv::Mat shownImage(const cv::Mat& image) {
  cv::Mat eight = toEightBits(image);
  const int channels = eight.channels();
  if (eight.depth() != CV_8U || (channels != 1 && channels != 3 && channels != 4))
    return cv::Mat::zeros(image.size(), CV_8U);
  if (channels == 4) {
    cv::Mat color;
    cv::cvtColor(eight, color, cv::COLOR_BGRA2BGR);
    return color;
  }
  return eight;
}

std::vector<Eigen::Vector3f> shownPoints(const DepthImage& image, const Pose& T_base_camera) {
  DepthParameters params;
  params.points = 1500;
  const DepthPoints points = makeDepthPoints(image, params);
  std::vector<Eigen::Vector3f> shown;
  const Eigen::Isometry3f to_base = T_base_camera.cast<float>();
  for (size_t i = 0; i < points.count; ++i)
    shown.emplace_back(to_base * Eigen::Vector3f(points.x[i], points.y[i], points.z[i]));
  return shown;
}

ViewMoment momentOf(const LiveInput& input, const LiveResult& result,
                    const LiveLocalizer& localizer, const std::optional<Pose>& truth,
                    size_t max_particles) {
  ViewMoment m;
  m.time = input.time;
  m.state = result.state;
  m.problem = result.problem;
  m.has_pose = localizer.isInitialized();
  m.estimate = result.estimate;
  m.truth = truth;
  m.clusters = result.clusters;
  m.foreign = result.objects;
  if (result.next_view) m.next_view = {result.next_view->first, result.next_view->second};
  if (m.has_pose) {
    const std::vector<Pose>& poses = localizer.filter().poses();
    const std::vector<double>& weights = localizer.filter().logWeights();
    m.particle_count = poses.size();
    const size_t step = std::max<size_t>(1, (poses.size() + max_particles - 1) / max_particles);
    const double best = weights.empty() ? 0 : *std::max_element(weights.begin(), weights.end());
    for (size_t i = 0; i < poses.size(); i += step) {
      m.particles.push_back(poses[i]);
      m.weights.push_back(static_cast<float>(std::exp(weights[i] - best)));
    }
  }
  if (!input.images.empty()) {
    const LiveInput::CameraImage& view = input.images.front();
    m.has_camera = true;
    m.camera = view.camera;
    m.T_base_camera = view.T_base_camera;
    m.image = view.image;
    m.mask = view.mask;
  }
  if (!result.images.empty()) m.prepared = result.images.front();
  for (const LiveInput::Depth& depth : input.depths) try {
      for (const Eigen::Vector3f& p : shownPoints(depth.image, depth.T_base_camera))
        m.depth_points.push_back(p);
    } catch (const Error&) {
      continue;  // the localizer reports what is wrong with the depth image
    }
  m.effective_sample_size = result.report.effective_sample_size;
  m.match_ratio = result.match_ratio;
  m.times.stage[0] = result.image_times.edges;
  m.times.stage[1] = result.image_times.field + result.image_times.table;
  m.times.stage[2] = result.report.likelihood_ms;
  m.times.stage[3] = result.report.refinement_ms;
  m.times.stage[4] = result.search_ms;
  m.times.total = m.times.stage[0] + m.times.stage[1] + result.report.total_ms + result.search_ms;
  return m;
}

}  // namespace edge_mcl
