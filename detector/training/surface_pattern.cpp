#include "edge_mcl/detector/training/surface_pattern.h"

#include <algorithm>
#include <cmath>

namespace edge_mcl {

namespace {

uint32_t mix(uint32_t h) {  // finaliser of MurmurHash3
  h ^= h >> 16;
  h *= 0x85ebca6bu;
  h ^= h >> 13;
  h *= 0xc2b2ae35u;
  return h ^ (h >> 16);
}

float hashed(int x, int y, int z, uint32_t seed) {
  const uint32_t h = mix(static_cast<uint32_t>(x) * 0x9e3779b1u ^
                         mix(static_cast<uint32_t>(y) * 0x7feb352du ^
                             mix(static_cast<uint32_t>(z) * 0x846ca68bu ^ seed)));
  return static_cast<float>(h >> 8) * 0x1.0p-24f;
}

/// Smooth noise, 0 to 1.
float valueNoise(const Eigen::Vector3f& p, uint32_t seed) {
  const Eigen::Vector3f cell = p.array().floor(), t = p - cell;
  const Eigen::Vector3f s = t.array().square() * (3 - 2 * t.array());
  const int x = static_cast<int>(cell.x()), y = static_cast<int>(cell.y()),
            z = static_cast<int>(cell.z());
  float sum = 0;
  for (int k = 0; k < 8; ++k) {
    const float weight =
        (k & 1 ? s.x() : 1 - s.x()) * (k & 2 ? s.y() : 1 - s.y()) * (k & 4 ? s.z() : 1 - s.z());
    sum += weight * hashed(x + (k & 1), y + (k >> 1 & 1), z + (k >> 2), seed);
  }
  return sum;
}

float clouds(const Eigen::Vector3f& p, uint32_t seed) {
  return 0.57f * valueNoise(p, seed) + 0.29f * valueNoise(2.1f * p, seed + 1) +
         0.14f * valueNoise(4.3f * p, seed + 2);
}

/// Returns two coordinates in the surface: the two axes along which its normal is smaller.
Eigen::Vector2f unroll(const Eigen::Vector3f& p, const Eigen::Vector3f& n) {
  const Eigen::Vector3f a = n.cwiseAbs();
  if (a.z() >= a.x() && a.z() >= a.y()) return {p.x(), p.y()};
  return a.x() >= a.y() ? Eigen::Vector2f(p.y(), p.z()) : Eigen::Vector2f(p.x(), p.z());
}

}  // namespace

Eigen::Vector3f SurfacePattern::at(const Eigen::Vector3f& point,
                                   const Eigen::Vector3f& normal) const {
  if (kind == kPlain) return color;
  const auto blend = [&](float t) -> Eigen::Vector3f { return color + t * (second - color); };
  if (kind == kClouds) return blend(clouds(point / size, seed));
  Eigen::Vector2f q = unroll(point, normal) / size;
  if (turned) std::swap(q.x(), q.y());
  const auto cell = [](float v) { return static_cast<int>(std::floor(v)); };
  switch (kind) {
    case kStripes:
      return hashed(cell(q.x()), 0, 0, seed) < 0.5f ? color : second;
    case kTiles: {
      const float gap = 0.04f, x = q.x() - std::floor(q.x()), y = q.y() - std::floor(q.y());
      if (x < gap || y < gap) return second;
      return color * (0.92f + 0.16f * hashed(cell(q.x()), cell(q.y()), 1, seed));
    }
    case kPlanks: {
      const int row = cell(q.y());
      const float x = 0.2f * q.x() + hashed(row, 3, 0, seed);
      if (q.y() - std::floor(q.y()) < 0.03f || x - std::floor(x) < 0.01f) return 0.6f * color;
      const float tone = hashed(row, cell(x), 2, seed);
      const float grain = valueNoise({1.5f * q.x(), 14 * q.y(), 0}, seed);
      return blend(0.6f * tone + 0.4f * grain);
    }
    case kWood:
      return blend(0.5f + 0.5f * std::sin(25 * clouds({0.35f * q.x(), 2.2f * q.y(), 0}, seed)));
    case kPatches: {  // coloured rectangles of two sizes, like pictures, books or clutter
      const float scale = hashed(cell(q.x()), cell(q.y()), 5, seed) < 0.5f ? 1 : 3;
      const int x = cell(scale * q.x()), y = cell(scale * q.y());
      return {hashed(x, y, 7, seed), hashed(x, y, 8, seed), hashed(x, y, 9, seed)};
    }
    default:
      return color;
  }
}

Eigen::Vector3f randomColor(TrainingRandom& random, Material material) {
  const auto number = [&](double low, double high) {
    return static_cast<float>(uniform(random, low, high));
  };
  const auto tinted = [&](float grey, float strength) -> Eigen::Vector3f {
    Eigen::Vector3f color;
    for (int k = 0; k < 3; ++k) color[k] = grey * (1 + strength * number(-1, 1));
    return color.cwiseMax(0.01f).cwiseMin(1.0f);
  };
  if (chance(random, 0.12)) return tinted(number(0.05, 0.8), 0.9f);
  switch (material) {
    case Material::kWall:
      return tinted(number(0.5, 0.98), number(0, 0.12));
    case Material::kFloor:
    case Material::kFurniture:
      if (chance(random, 0.55)) {  // wood
        const float tone = number(0.12, 0.8);
        return {tone, tone * number(0.6, 0.85), tone * number(0.3, 0.65)};
      }
      return tinted(number(0.03, 0.97), number(0, 0.15));
    case Material::kFabric:
      return tinted(number(0.04, 0.8), number(0.05, 0.7));
    case Material::kDevice:
      return tinted(chance(random, 0.7) ? number(0.02, 0.2) : number(0.3, 0.9), number(0, 0.08));
  }
  return Eigen::Vector3f::Constant(0.5f);
}

SurfacePattern randomPattern(TrainingRandom& random, Material material, double plain_share) {
  SurfacePattern p;
  p.color = randomColor(random, material);
  if (!chance(random, plain_share)) {
    using Kind = SurfacePattern::Kind;
    const Kind any = static_cast<Kind>(1 + choose(random, SurfacePattern::kKinds - 1));
    constexpr Kind kFloors[] = {Kind::kTiles, Kind::kPlanks, Kind::kPlanks, Kind::kWood,
                                Kind::kClouds};
    p.kind = material == Material::kFloor                              ? kFloors[choose(random, 5)]
             : material == Material::kFurniture && chance(random, 0.7) ? Kind::kWood
             : any == Kind::kPatches && !chance(random, 0.3)           ? Kind::kClouds
                                                                       : any;
  }
  const auto contrast = static_cast<float>(std::pow(uniform(random, 0, 1), 2));
  p.second = p.color + contrast * (randomColor(random, material) - p.color);
  p.size = static_cast<float>(std::exp(uniform(random, std::log(0.05), std::log(0.8))));
  p.shine = chance(random, 0.3) ? static_cast<float>(uniform(random, 0, 0.6)) : 0;
  p.seed = static_cast<uint32_t>(random());
  p.turned = chance(random, 0.5);
  return p;
}

}  // namespace edge_mcl
