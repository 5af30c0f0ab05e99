#include "apps/recordings/placement.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "edge_mcl/core/base/angles.h"
#include "edge_mcl/core/import/map_frame.h"

namespace edge_mcl {

Placement placementOf(const MapParameters& used, double scale, const Similarity& s) {
  Placement placement;
  placement.map = used;
  const Eigen::Affine3d before = mapTransform(used, scale);
  const Eigen::Matrix3d R0 =
      rotationFromAngles(used.roll_deg * kDegree, used.pitch_deg * kDegree, used.yaw_deg * kDegree);
  placement.whole.rotation = s.rotation * R0;
  placement.whole.scale = s.scale * scale;
  placement.whole.shift = s * before.translation();
  const Eigen::Matrix3d& R = placement.whole.rotation;
  placement.map.scale = placement.whole.scale;
  placement.map.x = placement.whole.shift.x();
  placement.map.y = placement.whole.shift.y();
  placement.map.z = placement.whole.shift.z();
  placement.map.yaw_deg = std::atan2(R(1, 0), R(0, 0)) / kDegree;
  placement.map.pitch_deg = std::asin(std::max(-1.0, std::min(1.0, -R(2, 0)))) / kDegree;
  placement.map.roll_deg = std::atan2(R(2, 1), R(2, 2)) / kDegree;
  return placement;
}

nlohmann::json jsonOf(const Placement& placement, double position_sigma, double rotation_sigma,
                      double scale_sigma) {
  const MapParameters& m = placement.map;
  return {{"scale", m.scale},
          {"position", {m.x, m.y, m.z}},
          {"yaw_deg", m.yaw_deg},
          {"pitch_deg", m.pitch_deg},
          {"roll_deg", m.roll_deg},
          {"sigma",
           {{"position_m", position_sigma},
            {"angle_deg", rotation_sigma / kDegree},
            {"scale", scale_sigma}}}};
}

std::string yamlOf(const Placement& placement) {
  // A model in coordinates of a country is 5,000 km from its origin. A millimetre there is 1e-8
  // degrees.
  char text[400];
  const MapParameters& m = placement.map;
  std::snprintf(text, sizeof text,
                "map:\n  scale: %.15g\n  x: %.6f\n  y: %.6f\n  z: %.6f\n  yaw_deg: %.13g\n"
                "  pitch_deg: %.13g\n  roll_deg: %.13g\n",
                m.scale, m.x, m.y, m.z, m.yaw_deg, m.pitch_deg, m.roll_deg);
  return text;
}

std::string transformLine(const Placement& placement, double scale) {
  constexpr double kMetric = 0.01;
  if (std::abs(placement.map.scale / scale - 1) >= kMetric) return "";
  const MapParameters& m = placement.map;
  const Eigen::Quaterniond q(placement.whole.rotation);
  char text[300];
  std::snprintf(text, sizeof text,
                "as a transform of a model in metres: static_transform_publisher %.6f %.6f %.6f "
                "%.12f %.12f %.12f %.12f OTHER_FRAME map\n",
                m.x, m.y, m.z, q.x(), q.y(), q.z(), q.w());
  return text;
}

}  // namespace edge_mcl
