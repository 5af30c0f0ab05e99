#include "edge_mcl/core/places/free_space.h"

#include <tbb/parallel_for.h>

#include <cmath>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/mesh/closest_point.h"

namespace edge_mcl {

namespace {

/// Unit vectors that are spread evenly over the sphere (A. Gonzalez, "Measurement of areas on a
/// sphere using Fibonacci and latitude-longitude lattices", Mathematical Geosciences 42, 2010).
std::vector<Eigen::Vector3d> directions(int count) {
  const double golden = M_PI * (3 - std::sqrt(5.0));
  std::vector<Eigen::Vector3d> result;
  for (int i = 0; i < count; ++i) {
    const double z = 1 - (2 * i + 1.0) / count, r = std::sqrt(1 - z * z);
    result.emplace_back(r * std::cos(golden * i), r * std::sin(golden * i), z);
  }
  return result;
}

}  // namespace

FreeSpace::FreeSpace(const MeshModel& mesh, const Options& options) : options_(options) {
  if (mesh.vertices.empty()) throw InputError("free space: the model is empty");
  low_ = high_ = mesh.vertices.front().cast<double>();
  for (const Eigen::Vector3f& v : mesh.vertices) {
    low_ = low_.cwiseMin(v.cast<double>());
    high_ = high_.cwiseMax(v.cast<double>());
  }
  if (!mesh.triangles.empty()) {
    scene_ = std::make_unique<RayScene>(mesh);
    closest_ = std::make_unique<ClosestFace>(mesh);
  }
  // A coarse grid tells whether the model surrounds any space.
  constexpr double kLooks = 4000;
  const double box = (high_ - low_).cwiseMax(1e-3).prod();
  const double spacing = std::cbrt(box / kLooks);
  enclosed_ = scene_ != nullptr && options_.enclosure > 0;
  const double cell = spacing * spacing * spacing;
  volume_ = static_cast<double>(places(spacing).size()) * cell;
  // Share of the bounds; with less free space the model surrounds nothing.
  constexpr double kNoInside = 0.02;
  if (enclosed_ && volume_ < kNoInside * box) {
    enclosed_ = false;
    volume_ = static_cast<double>(places(spacing).size()) * cell;
  }
}

FreeSpace::~FreeSpace() = default;

bool FreeSpace::isClear(const Eigen::Vector3d& position, double clearance) const {
  return !closest_ || !closest_->find(position, clearance).found;
}

bool FreeSpace::isSurrounded(const Eigen::Vector3d& position) const {
  static const std::vector<Eigen::Vector3d> kDirections = directions(48);
  const double reach = 2 * (high_ - low_).norm();
  int blocked = 0;
  for (const Eigen::Vector3d& d : kDirections) {
    const Eigen::Vector3d end = position + reach * d;
    blocked +=
        edge_mcl::isBlocked(scene_->get(), position.cast<float>(), end.cast<float>(), 0, 0) ? 1 : 0;
  }
  return blocked >= options_.enclosure * static_cast<double>(kDirections.size());
}

bool FreeSpace::contains(const Eigen::Vector3d& position) const {
  if ((position.array() < low_.array()).any() || (position.array() > high_.array()).any())
    return false;
  return isClear(position, options_.clearance) && (!enclosed_ || isSurrounded(position));
}

bool FreeSpace::admits(const Eigen::Vector3d& position) const {
  return isClear(position, 0.5 * options_.clearance) && (!enclosed_ || isSurrounded(position));
}

std::vector<Eigen::Vector3d> FreeSpace::places(double spacing) const {
  // The outermost positions lie half a step inside the bounds.
  Eigen::Vector3i count;
  for (int k = 0; k < 3; ++k)
    count[k] = std::max(1, static_cast<int>(std::ceil((high_[k] - low_[k]) / spacing)));
  const Eigen::Vector3d step = (high_ - low_).cwiseQuotient(count.cast<double>());
  const size_t total = static_cast<size_t>(count.x()) * count.y() * count.z();
  const auto at = [&](size_t i) {
    const size_t x = i % count.x(), y = i / count.x() % count.y(),
                 z = i / (static_cast<size_t>(count.x()) * count.y());
    return Eigen::Vector3d(low_ + step.cwiseProduct(Eigen::Vector3d(static_cast<double>(x) + 0.5,
                                                                    static_cast<double>(y) + 0.5,
                                                                    static_cast<double>(z) + 0.5)));
  };
  std::vector<char> free(total);
  tbb::parallel_for(size_t{0}, total, [&](size_t i) { free[i] = contains(at(i)) ? 1 : 0; });
  std::vector<Eigen::Vector3d> result;
  for (size_t i = 0; i < total; ++i)
    if (free[i]) result.push_back(at(i));
  return result;
}

}  // namespace edge_mcl
