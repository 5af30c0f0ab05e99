/// A raster of directions around an axis. Lines along the axis are easy to compare on it.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>

namespace edge_mcl {

/// A line parallel to an axis, seen from any place, is an arc of a great circle through the axis.
/// It has one angle around the axis, and a range of angles from the axis. So it is one row of the
/// raster and some neighbouring bits of it. Axes are those of a building (BuildingAxes).
namespace raster {

constexpr int kAround = 128;  ///< rows of 2.8 degrees: the angle around the axis
constexpr int kAlong = 64;    ///< bits of a row, 2.8 degrees each: the angle from the axis
constexpr double kRow = 2 * M_PI / kAround, kBit = M_PI / kAlong;

/// Row of a direction. @param axis 0, 1, 2. @param v any length, not parallel to the axis.
inline int rowOf(const Eigen::Vector3d& v, int axis) {
  const double angle = std::atan2(v[(axis + 2) % 3], v[(axis + 1) % 3]);
  const int row = static_cast<int>(std::floor(angle / kRow));
  return (row % kAround + kAround) % kAround;
}

/// Angle from the axis, rad.
inline double alongOf(const Eigen::Vector3d& v, int axis) {
  return std::atan2(std::hypot(v[(axis + 1) % 3], v[(axis + 2) % 3]), v[axis]);
}

/// Direction at the middle of a bit.
inline Eigen::Vector3d directionAt(int row, int bit, int axis) {
  const double around = (row + 0.5) * kRow, along = (bit + 0.5) * kBit;
  Eigen::Vector3d v;
  v[axis] = std::cos(along);
  v[(axis + 1) % 3] = std::sin(along) * std::cos(around);
  v[(axis + 2) % 3] = std::sin(along) * std::sin(around);
  return v;
}

/// Bits of a range of angles from the axis, in any order.
inline uint64_t bitsOf(double from, double to) {
  if (from > to) std::swap(from, to);
  const int first = std::clamp(static_cast<int>(from / kBit), 0, kAlong - 1),
            last = std::clamp(static_cast<int>(to / kBit), 0, kAlong - 1);
  return (~uint64_t{0} >> (kAlong - 1 - (last - first))) << first;
}

}  // namespace raster

}  // namespace edge_mcl
