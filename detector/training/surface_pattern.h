/// Makes random patterns for the surfaces of training images, so that no two rooms look alike.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <random>

namespace edge_mcl {

using TrainingRandom = std::mt19937_64;

/// Random number from low to high.
inline double uniform(TrainingRandom& random, double low, double high) {
  return low + (high - low) * (static_cast<double>(random() >> 11) * 0x1.0p-53);
}
/// True with this probability.
inline bool chance(TrainingRandom& random, double probability) {
  return uniform(random, 0, 1) < probability;
}
/// Random number from 0 to count - 1.
inline int choose(TrainingRandom& random, int count) {
  return static_cast<int>(random() % static_cast<uint64_t>(count));
}

/// Look of one material.
struct SurfacePattern {
  enum Kind { kPlain, kClouds, kStripes, kTiles, kPlanks, kWood, kPatches, kKinds };
  Kind kind = kPlain;
  Eigen::Vector3f color = Eigen::Vector3f::Constant(0.5f), second = color;
  float size = 0.2f;  ///< of the pattern's elements, m
  float shine = 0;    ///< share of lamp light that is mirrored
  uint32_t seed = 0;
  bool turned = false;  ///< the pattern is turned by a quarter

  /// Returns the colour at a point. @param point axes of the object, m. @param normal axes of the
  /// object.
  Eigen::Vector3f at(const Eigen::Vector3f& point, const Eigen::Vector3f& normal) const;
};

/// Kind of the thing that a surface belongs to. It decides which colours are likely.
enum class Material { kWall, kFloor, kFurniture, kFabric, kDevice };

/// Returns a random colour (red, green, blue, 0 to 1). Walls are mostly light. Furniture is mostly
/// of wood, white, grey or black. Devices are mostly dark or light grey. 12 % of all surfaces have
/// any colour.
Eigen::Vector3f randomColor(TrainingRandom& random, Material material);
/// Returns a random pattern. @param plain_share probability of a plain surface.
SurfacePattern randomPattern(TrainingRandom& random, Material material, double plain_share);

}  // namespace edge_mcl
