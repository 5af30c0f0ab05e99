#include "edge_mcl/core/import/map_frame.h"

#include <algorithm>
#include <cmath>
#include <sstream>

#include "edge_mcl/core/base/angles.h"
#include "edge_mcl/core/base/se3.h"

namespace edge_mcl {

namespace {

/// The value below which a share of the values lies.
double quantile(std::vector<double>* values, double share) {
  const auto at = values->begin() +
                  static_cast<std::ptrdiff_t>(share * static_cast<double>(values->size() - 1));
  std::nth_element(values->begin(), at, values->end());
  return *at;
}

}  // namespace

Eigen::Vector3d farPart(const std::vector<Eigen::Vector3d>& points, double far) {
  constexpr double kRound = 100;
  if (points.empty()) return Eigen::Vector3d::Zero();
  Eigen::Vector3d middle;
  bool is_far = false;
  std::vector<double> values(points.size());
  for (int k = 0; k < 3; ++k) {
    std::transform(points.begin(), points.end(), values.begin(),
                   [&](const Eigen::Vector3d& p) { return p[k]; });
    middle[k] = quantile(&values, 0.5);
    const double half = quantile(&values, 0.75) - quantile(&values, 0.25);
    is_far = is_far || (std::abs(middle[k]) > far && std::abs(middle[k]) > 2 * half);
  }
  if (!is_far) return Eigen::Vector3d::Zero();
  return ((middle / kRound).array().round() * kRound + 0.0).matrix();  // no minus before a zero
}

Eigen::Affine3d mapTransform(const MapParameters& params, double scale) {
  Eigen::Affine3d transform = Eigen::Affine3d::Identity();
  transform.translate(Eigen::Vector3d(params.x, params.y, params.z));
  transform.rotate(rotationFromAngles(params.roll_deg * kDegree, params.pitch_deg * kDegree,
                                      params.yaw_deg * kDegree));
  Eigen::Vector3d axes = Eigen::Vector3d::Constant(scale);
  for (int k = 0; k < 3; ++k)
    if (params.mirror == std::string(1, "xyz"[k])) axes[k] = -scale;
  transform.scale(axes);
  return transform;
}

Eigen::Vector3d mapOrigin(const MapParameters& params, const std::vector<Eigen::Vector3d>& points) {
  if (const auto given = params.givenOrigin()) return Eigen::Vector3d(given->data());
  constexpr double kFar = 5000;  // single precision is good to 0.25 mm at this distance
  return farPart(points, kFar);
}

std::string metresText(const Eigen::Vector3d& point) {
  std::ostringstream text;
  text.precision(12);
  text << "(" << point.x() << ", " << point.y() << ", " << point.z() << ")";
  return text.str();
}

std::string originNote(const Eigen::Vector3d& origin) {
  return "the map's origin is at " + metresText(origin) +
         " in the file's coordinates, m (see map.origin)";
}

std::string sizeDoubt(double diagonal) {
  constexpr double kTown = 500;  // m
  if (diagonal <= kTown) return "";
  return "the model is " + std::to_string(std::lround(diagonal)) +
         " m across. Is it in centimetres or millimetres? Then set map.scale to 0.01 or 0.001";
}

}  // namespace edge_mcl
