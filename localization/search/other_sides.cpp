#include "edge_mcl/localization/search/other_sides.h"

#include <algorithm>

#include "edge_mcl/core/mesh/mesh_shapes.h"

namespace edge_mcl {

namespace {

/// What is lower lies on the floor, or is the floor.
constexpr double kStanding = 0.15;  // m
/// The largest things that are looked at. A view of many things looks like no other.
constexpr size_t kMost = 3;

}  // namespace

OtherSides::OtherSides(const LocalizationMap& map) {
  if (map.freeSpace()->isEnclosed()) return;
  const MeshModel& mesh = map.mesh();
  std::vector<Eigen::AlignedBox3f> standing;
  if (!mesh.triangles.empty()) standing = findShapes(mesh).box;
  standing.erase(std::remove_if(standing.begin(), standing.end(),
                                [](const Eigen::AlignedBox3f& box) {
                                  return static_cast<double>(box.sizes().z()) < kStanding;
                                }),
                 standing.end());
  if (standing.empty()) standing.emplace_back(mesh.lowest, mesh.highest);
  std::stable_sort(standing.begin(), standing.end(), [](const auto& a, const auto& b) {
    return a.diagonal().norm() > b.diagonal().norm();
  });
  if (standing.size() > kMost) standing.resize(kMost);
  for (const Eigen::AlignedBox3f& box : standing) middles_.push_back(box.center().cast<double>());
}

std::vector<Pose> OtherSides::of(const Pose& pose) const {
  std::vector<Pose> found;
  for (const Eigen::Vector3d& middle : middles_)
    for (int quarter = 1; quarter < 4; ++quarter) {
      const Eigen::Matrix3d turn =
          Eigen::AngleAxisd(quarter * M_PI / 2, Eigen::Vector3d::UnitZ()).toRotationMatrix();
      Pose turned = Pose::Identity();
      turned.linear() = turn * pose.linear();
      turned.translation() = middle + turn * (pose.translation() - middle);
      found.push_back(turned);
    }
  return found;
}

}  // namespace edge_mcl
