/// Places from which a scan is looked at: as many as its surfaces need, not as its volume has.
#pragma once

#include <Eigen/Core>
#include <array>
#include <functional>
#include <map>
#include <vector>

namespace edge_mcl {

/// Which places are wanted.
struct ScanPlaces {
  double spacing = 0.8;  ///< smallest distance of two places, m
  /// A surface that this many places have seen needs no more of them.
  int times_seen = 8;
  double far = 6;  ///< surfaces beyond this distance do not count as seen, m
};

/// A point of a surface that is seen from a place.
struct SurfacePiece {
  Eigen::Vector3f point, normal;  ///< map frame, metres
  float distance = 0;             ///< from the place, m
};

/// Visits the corners of a grid in a box, such that the first ones are spread widely and each later
/// one lies between earlier ones. @param spacing of the whole grid, m.
void forSpreadPlaces(const Eigen::Vector3d& low, const Eigen::Vector3d& high, double spacing,
                     const std::function<void(const Eigen::Vector3d&)>& visit);

/// Counts how many places have seen each part of the surfaces.
class SeenSurface {
 public:
  SeenSurface(int times_seen, double far) : times_seen_(times_seen), far_(far) {}

  /// Counts what a place sees. @return false, and nothing is counted, when enough places have seen
  /// most of it.
  bool add(const std::vector<SurfacePiece>& pieces);

 private:
  /// Cube of space, and the axis and side that the surface faces.
  using Part = std::array<int, 4>;
  static Part partOf(const SurfacePiece& piece);

  int times_seen_;
  double far_;
  std::map<Part, int> count_;
};

}  // namespace edge_mcl
