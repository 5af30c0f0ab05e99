#include "edge_mcl/gpu/conversion.h"

#include <cmath>

namespace edge_mcl::gpu {

Camera cameraOf(const CameraModel& camera) {
  Camera c{};
  c.fx = static_cast<float>(camera.fx);
  c.fy = static_cast<float>(camera.fy);
  c.cx = static_cast<float>(camera.cx);
  c.cy = static_cast<float>(camera.cy);
  c.last_x = static_cast<float>(camera.width - 1);
  c.last_y = static_cast<float>(camera.height - 1);
  c.max_radius2 = static_cast<float>(camera.maxPlaneRadius2());
  c.min_depth = static_cast<float>(CameraModel::kMinDepth);
  c.distortion = static_cast<int32_t>(camera.distortion);
  for (int i = 0; i < 8; ++i) c.k[i] = static_cast<float>(camera.coefficients[i]);
  return c;
}

Table tableOf(const ScoreTable& table) {
  return {table.stride(),     table.rows(),  table.bins(),
          table.hasIgnored(), table.scale(), table.offset()};
}

Rule ruleOf(const LikelihoodFrame& frame) {
  const LikelihoodParameters& p = frame.params;
  return {p.model == LikelihoodModel::kPaper, static_cast<float>(1 / p.line_saturation),
          p.border_fade > 0 ? static_cast<float>(1 / p.border_fade) : 1e9f,
          static_cast<float>(spacingScale(frame)), frame.thinning};
}

Combination combinationOf(const LikelihoodParameters& params) {
  return {params.scale, params.line_correlation, std::log(params.alpha), params.k};
}

Particle particleOf(const edge_mcl::Pose& T_map_camera, uint32_t cell) {
  Particle p{};
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) p.rotation[3 * r + c] = T_map_camera.linear()(r, c);
    p.position[r] = T_map_camera.translation()[r];
  }
  p.cell = cell;
  return p;
}

CellData cellOf(const VisibleSet& set, const Eigen::Vector3d& origin) {
  CellData data{};
  for (int i = 0; i < 3; ++i) data.cell.origin[i] = origin[i];
  data.segments.reserve(set.segments.size());
  for (size_t k = 0; k < set.segments.size(); ++k) {
    const VisibleSet::Segment& seen = set.segments[k];
    const EdgeSegment& edge = set.edgeSegment(seen);
    const Eigen::Vector3f centre = (edge.centre.cast<double>() - origin).cast<float>();
    const Eigen::Vector3f tangent = set.line(seen).tangent();
    Segment s{};
    for (int i = 0; i < 3; ++i) {
      s.centre[i] = centre[i];
      s.tangent[i] = tangent[i];
    }
    s.seen = seen.samples | static_cast<uint32_t>(seen.facing) << 16;
    s.first = edge.first_sample;
    data.segments.push_back(s);
    if (set.endsGroup(k)) data.group_ends.push_back(static_cast<uint32_t>(k + 1));
  }
  data.cell.group_count = static_cast<uint32_t>(data.group_ends.size());
  return data;
}

}  // namespace edge_mcl::gpu
