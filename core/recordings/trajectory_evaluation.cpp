#include "edge_mcl/core/recordings/trajectory_evaluation.h"

#include <algorithm>
#include <cmath>

namespace edge_mcl {

ErrorSummary summarize(std::vector<double> values) {
  ErrorSummary s;
  if (values.empty()) return s;
  std::sort(values.begin(), values.end());
  const auto n = static_cast<double>(values.size());
  double squares = 0;
  for (double v : values) {
    s.mean += v / n;
    squares += v * v / n;
  }
  const auto percentile = [&](double q) {
    const double at = q * (n - 1);
    const auto low = static_cast<size_t>(at), high = std::min(low + 1, values.size() - 1);
    return values[low] + (at - static_cast<double>(low)) * (values[high] - values[low]);
  };
  s.rmse = std::sqrt(squares);
  s.median = percentile(0.5);
  s.p90 = percentile(0.9);
  s.max = values.back();
  return s;
}

TrajectoryErrors evaluateTrajectory(const Trajectory& estimate, const Trajectory& reference,
                                    double max_time_difference, double position_limit,
                                    double rotation_limit) {
  constexpr double kDegrees = 180 / M_PI;
  TrajectoryErrors errors;
  errors.reference_poses = reference.size();
  std::vector<double> relative_position, relative_rotation;
  const StampedPose *last_reference = nullptr, *last_estimate = nullptr;
  size_t good = 0;
  for (const StampedPose& r : reference) {
    auto it = std::lower_bound(estimate.begin(), estimate.end(), r.time,
                               [](const StampedPose& p, double t) { return p.time < t; });
    if (it == estimate.end() ||
        (it != estimate.begin() && r.time - (it - 1)->time < it->time - r.time))
      if (it != estimate.begin()) --it;
    if (it == estimate.end() || std::abs(it->time - r.time) > max_time_difference + 1e-9) continue;
    const double position = (it->pose.translation() - r.pose.translation()).norm();
    const double rotation = rotationAngle(it->pose, r.pose) * kDegrees;
    errors.time.push_back(r.time);
    errors.position.push_back(position);
    errors.rotation.push_back(rotation);
    if (position < position_limit && rotation < rotation_limit) ++good;
    if (last_reference) {
      const Pose of_reference = last_reference->pose.inverse() * r.pose;
      const Pose of_estimate = last_estimate->pose.inverse() * it->pose;
      const Pose difference = of_reference.inverse() * of_estimate;
      relative_position.push_back(difference.translation().norm());
      relative_rotation.push_back(logSo3(difference.linear()).norm() * kDegrees);
    }
    last_reference = &r;
    last_estimate = &*it;
  }
  errors.matched = errors.time.size();
  errors.position_summary = summarize(errors.position);
  errors.rotation_summary = summarize(errors.rotation);
  errors.relative_position = summarize(relative_position);
  errors.relative_rotation = summarize(relative_rotation);
  if (!reference.empty())
    errors.success_share = static_cast<double>(good) / static_cast<double>(reference.size());
  if (errors.matched > 0)
    errors.success_share_of_matched =
        static_cast<double>(good) / static_cast<double>(errors.matched);
  return errors;
}

}  // namespace edge_mcl
