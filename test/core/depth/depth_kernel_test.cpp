#include "edge_mcl/core/depth/depth_kernel.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <vector>

#include "edge_mcl/core/depth/depth_points.h"
#include "support/random_points.h"

namespace edge_mcl {
namespace {

using test::anywhere;
using test::Random;
using test::uniform;

constexpr float kClutter = 0.3f;
constexpr int kBricks[3] = {2, 3, 2};
constexpr uint32_t kFar = DistanceField::kFar;

/// A grid with random distances and gradients. Every third brick is the empty one, and every fourth
/// voxel of the other bricks is far.
struct RandomGrid {
  explicit RandomGrid(uint64_t seed) {
    Random random(seed);
    int32_t count = 1;
    for (int i = 0; i < kBricks[0] * kBricks[1] * kBricks[2]; ++i)
      brick.push_back(i % 3 == 0 ? 0 : count++);
    voxel.assign(static_cast<size_t>(count) * DistanceField::kBrickVoxels, kFar);
    for (size_t i = DistanceField::kBrickVoxels; i < voxel.size(); ++i) {
      const auto bits = static_cast<uint32_t>(random());
      voxel[i] = i % 4 == 0 ? kFar : (bits & ~255u) | (bits & 255u) % kFar;
    }
  }
  DistanceField::Grid grid() const {
    return {Eigen::Vector3d(5, -3, 1),
            0.05,
            0.3,
            0.35 / 254,
            {kBricks[0], kBricks[1], kBricks[2]},
            brick.data(),
            voxel.data()};
  }
  std::vector<int32_t> brick;
  std::vector<uint32_t> voxel;
};

/// Points with their weights, as the kernel takes them.
struct Points {
  std::vector<float> x, y, z, half_inverse_variance, peak;
  void add(const Eigen::Vector3d& p, double half, double height) {
    x.push_back(static_cast<float>(p.x()));
    y.push_back(static_cast<float>(p.y()));
    z.push_back(static_cast<float>(p.z()));
    half_inverse_variance.push_back(static_cast<float>(half));
    peak.push_back(static_cast<float>(height));
  }
  DepthKernelPoints arrays() const {
    return {x.size(), x.data(), y.data(), z.data(), half_inverse_variance.data(), peak.data()};
  }
};

/// Voxel coordinates of a point.
Eigen::Vector3d inVoxels(const DepthKernelPose& pose, const Points& points, size_t i) {
  const float* r = pose.rotation;
  Eigen::Vector3d q;
  for (int k = 0; k < 3; ++k)
    q[k] = static_cast<double>(r[3 * k]) * points.x[i] +
           static_cast<double>(r[3 * k + 1]) * points.y[i] +
           static_cast<double>(r[3 * k + 2]) * points.z[i] + pose.translation[k];
  return q;
}

/// Height of the Gaussian at a point, from the definition of the grid, in double precision. A point
/// outside the grid, in an empty brick or in a far voxel has none.
double plainGaussian(const DistanceField::Grid& grid, const Eigen::Vector3d& q, double half,
                     double peak) {
  int brick = 0, voxel = 0;
  Eigen::Vector3d from_centre;
  for (int k = 2; k >= 0; --k) {
    if (!(q[k] >= 0 && q[k] < 8 * grid.bricks[k])) return 0;
    const int cell = static_cast<int>(std::floor(q[k]));
    brick = brick * grid.bricks[k] + cell / 8;
    voxel = voxel * 8 + cell % 8;
    from_centre[k] = grid.voxel_size * (q[k] - cell - 0.5);
  }
  if (grid.brick[brick] == 0) return 0;
  const uint32_t word = grid.voxel[512 * grid.brick[brick] + voxel];
  if ((word & 255u) == kFar) return 0;
  double distance = grid.distance_step * (word & 255u);
  for (int k = 0; k < 3; ++k) {
    int part = static_cast<int>(word >> (8 * (k + 1)) & 255u);
    if (part > 127) part -= 256;
    distance += part / 127.0 * from_centre[k];
  }
  return peak * std::exp(-distance * distance * half);
}

DepthKernelPose poseOf(const Eigen::Matrix3d& rotation, const Eigen::Vector3d& translation) {
  DepthKernelPose pose{};
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column)
      pose.rotation[3 * row + column] = static_cast<float>(rotation(row, column));
    pose.translation[row] = static_cast<float>(translation[row]);
  }
  return pose;
}

/// The truth is the same sum, point by point and in double precision. Points whose voxel depends on
/// rounding are not used.
TEST(DepthKernel, AgreesWithThePlainSum) {
  Random random(1);
  const RandomGrid store(2);
  const DistanceField::Grid grid = store.grid();
  size_t on_model = 0;
  for (int round = 0; round < 50; ++round) {
    const Eigen::Matrix3d turn =
        Eigen::AngleAxisd(uniform(&random, 0, 3), anywhere(&random).normalized())
            .toRotationMatrix() /
        grid.voxel_size;
    const DepthKernelPose pose = poseOf(turn, 4 * anywhere(&random));
    const size_t count = DepthPoints::kPadding * (1 + round % 7);
    Points points;
    double score = 0, agreement = 0;
    while (points.x.size() < count) {
      // A little more than the grid.
      const Eigen::Vector3d wanted(uniform(&random, -1, 17), uniform(&random, -1, 25),
                                   uniform(&random, -1, 17));
      const Eigen::Vector3d t(pose.translation[0], pose.translation[1], pose.translation[2]);
      Points candidate;
      candidate.add(turn.inverse() * (wanted - t), uniform(&random, 5, 200),
                    uniform(&random, 1, 8));
      const Eigen::Vector3d q = inVoxels(pose, candidate, 0);
      if ((q - q.array().round().matrix()).cwiseAbs().minCoeff() < 1e-3) continue;
      points.add({candidate.x[0], candidate.y[0], candidate.z[0]},
                 candidate.half_inverse_variance[0], candidate.peak[0]);
      const double gaussian =
          plainGaussian(grid, q, candidate.half_inverse_variance[0], candidate.peak[0]);
      score += std::log(kClutter + gaussian);
      agreement += gaussian / (kClutter + gaussian);
      on_model += gaussian > 0.1;
    }
    const DepthKernelResult result = runDepthKernel(grid, points.arrays(), pose, kClutter);
    // A coordinate of 25 voxels has an error of up to 4e-6 voxels, which is 2e-7 m. The distance is
    // at most 0.45 m, so the exponent d^2 / (2 sigma^2) has an error of up to
    // 2 * 0.45 * 2e-7 * 200 = 4e-5 per point.
    const double tolerance = 5e-5 * static_cast<double>(count);
    EXPECT_NEAR(result.score, score, tolerance);
    EXPECT_NEAR(result.agreement, agreement, tolerance);
  }
  EXPECT_GT(on_model, 500u);
}

/// Points of a voxel that is far, of an empty brick, outside the grid and without position are
/// clutter. Each adds the logarithm of the clutter and no agreement. Padding has no peak.
TEST(DepthKernel, WhatIsNotOnTheModelIsClutter) {
  RandomGrid store(3);
  for (size_t i = DistanceField::kBrickVoxels; i < store.voxel.size(); ++i) store.voxel[i] = 0;
  store.voxel[DistanceField::kBrickVoxels] = kFar;  // first voxel of the second brick
  const DistanceField::Grid grid = store.grid();
  const DepthKernelPose pose = poseOf(Eigen::Matrix3d::Identity(), {0, 0, 0});
  const auto result = [&](const Eigen::Vector3d& voxel, double half, double peak) {
    Points points;
    for (size_t i = 0; i < 2 * DepthPoints::kPadding; ++i) points.add(voxel, half, peak);
    return runDepthKernel(grid, points.arrays(), pose, kClutter);
  };
  const double count = 2 * DepthPoints::kPadding;
  const double clutter = count * std::log(static_cast<double>(kClutter));
  // The distance in the voxel is 0 on the surface, so the Gaussian has its full height.
  const DepthKernelResult on_model = result({9.5, 0.5, 0.5}, 100, 4);
  EXPECT_NEAR(on_model.score, count * std::log(4.3), 1e-5 * count);  // single precision
  EXPECT_NEAR(on_model.agreement, count * 4 / 4.3, 1e-5 * count);
  for (const Eigen::Vector3d& q :
       {Eigen::Vector3d(8.5, 0.5, 0.5), Eigen::Vector3d(3, 3, 3), Eigen::Vector3d(-0.5, 9, 9),
        Eigen::Vector3d(9, 24.5, 9), Eigen::Vector3d(9, 9, 1e9), Eigen::Vector3d(9, -1e9, 9),
        Eigen::Vector3d(NAN, 9, 9), Eigen::Vector3d(9, 9, INFINITY)}) {
    EXPECT_NEAR(result(q, 100, 4).score, clutter, 1e-5 * count) << q.transpose();
    EXPECT_EQ(result(q, 100, 4).agreement, 0) << q.transpose();
  }
  EXPECT_NEAR(result({9.5, 0.5, 0.5}, 0, 0).score, clutter, 1e-5 * count);  // padding
  EXPECT_EQ(result({9.5, 0.5, 0.5}, 0, 0).agreement, 0);
}

TEST(DepthKernel, WithoutPointsTheSumsAreZero) {
  const RandomGrid store(4);
  const DepthKernelResult result = runDepthKernel(
      store.grid(), Points().arrays(), poseOf(Eigen::Matrix3d::Identity(), {0, 0, 0}), kClutter);
  EXPECT_EQ(result.score, 0);
  EXPECT_EQ(result.agreement, 0);
}

/// Good fits multiply to large numbers before the logarithm is taken. A sensor of 2 mm in a field
/// with a truncation of 1 m has a peak of 0.7 * 1 * 0.8 / 0.002 = 280. A thousand of them must
/// neither overflow nor lose precision.
TEST(DepthKernel, ManyGoodFitsDoNotOverflow) {
  RandomGrid store(5);
  for (size_t i = DistanceField::kBrickVoxels; i < store.voxel.size(); ++i) store.voxel[i] = 0;
  Points points;
  constexpr int kCount = 1008;  // a multiple of the padding
  for (int i = 0; i < kCount; ++i) points.add({9.5, 0.5, 0.5}, 1e5, 280);
  const DepthKernelResult result = runDepthKernel(
      store.grid(), points.arrays(), poseOf(Eigen::Matrix3d::Identity(), {0, 0, 0}), kClutter);
  EXPECT_NEAR(result.score, kCount * std::log(280.3), 1e-5 * result.score);  // single precision
}

}  // namespace
}  // namespace edge_mcl
