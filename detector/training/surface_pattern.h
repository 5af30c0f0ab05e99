/// What surfaces of training images look like: procedural patterns, so that no two rooms are alike.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <random>

namespace edge_mcl {

using TrainingRandom = std::mt19937_64;

inline double uniform(TrainingRandom& random, double low, double high) {
  return low + (high - low) * (static_cast<double>(random() >> 11) * 0x1.0p-53);
}
inline bool chance(TrainingRandom& random, double probability) {
  return uniform(random, 0, 1) < probability;
}
/// 0 to count - 1.
inline int choose(TrainingRandom& random, int count) {
  return static_cast<int>(random() % static_cast<uint64_t>(count));
}

/// One material's look.
struct SurfacePattern {
  enum Kind { kPlain, kClouds, kStripes, kTiles, kPlanks, kWood, kPatches, kKinds };
  Kind kind = kPlain;
  Eigen::Vector3f color = Eigen::Vector3f::Constant(0.5f), second = color;
  float size = 0.2f;  ///< metres
  float shine = 0;    ///< share of mirrored lamp light
  uint32_t seed = 0;
  bool turned = false;  ///< patterns run the other way

  /// @param point in the surface's own axes, metres. @param normal in the same.
  Eigen::Vector3f at(const Eigen::Vector3f& point, const Eigen::Vector3f& normal) const;
};

/// What a surface belongs to, which decides its likely colours.
enum class Material { kWall, kFloor, kFurniture, kFabric, kDevice };

/// Walls are mostly light, furniture of wood, white, grey or black, devices dark or light grey; a
/// part of each is of any colour.
Eigen::Vector3f randomColor(TrainingRandom& random, Material material);
SurfacePattern randomPattern(TrainingRandom& random, Material material, double plain_share);

}  // namespace edge_mcl
