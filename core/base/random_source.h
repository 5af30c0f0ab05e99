/// Seeded random numbers with the same sequence on every platform.
#pragma once

#include <cmath>
#include <cstdint>
#include <random>

#include "edge_mcl/core/base/se3.h"

namespace edge_mcl {

/// Random numbers from a seed. std::mt19937_64 is fully specified, but the distributions of the
/// standard library are not. So the distributions are implemented here.
class RandomSource {
 public:
  explicit RandomSource(uint64_t seed) : engine_(seed) {}

  /// Uniform number in [0, 1).
  double uniform() { return static_cast<double>(engine_() >> 11) * 0x1.0p-53; }

  /// Standard normal number, by Marsaglia's polar method.
  double normal() {
    if (has_spare_) {
      has_spare_ = false;
      return spare_;
    }
    double u = 0, v = 0, s = 0;
    do {
      u = 2 * uniform() - 1;
      v = 2 * uniform() - 1;
      s = u * u + v * v;
    } while (s >= 1 || s == 0);
    const double factor = std::sqrt(-2 * std::log(s) / s);
    spare_ = v * factor;
    has_spare_ = true;
    return u * factor;
  }

  /// Six independent standard normal numbers.
  Twist normalTwist() {
    Twist xi;
    for (int i = 0; i < 6; ++i) xi[i] = normal();
    return xi;
  }

  /// Unit vector with a uniform distribution on the sphere.
  Eigen::Vector3d direction() {
    Eigen::Vector3d d;
    do d = Eigen::Vector3d(normal(), normal(), normal());
    while (d.norm() < 1e-9);
    return d.normalized();
  }

 private:
  std::mt19937_64 engine_;
  double spare_ = 0;
  bool has_spare_ = false;
};

}  // namespace edge_mcl
