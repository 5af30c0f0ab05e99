#include "edge_mcl/core/likelihood/cpu_kernel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <tuple>
#include <vector>

#include "edge_mcl/core/base/random_source.h"
#include "edge_mcl/core/base/se3.h"
#include "support/scenes.h"

namespace edge_mcl {
namespace {

constexpr int kWidth = 60, kHeight = 40, kBins = 8;

CameraModel smallCamera() {
  CameraModel camera = test::pinhole(kWidth, kHeight, 50);
  camera.fy = 50;
  camera.cx = 29.5;
  camera.cy = 19.5;
  camera.validate("small camera");  // the bounds of the view depend on the centre
  return camera;
}

/// The byte of the table grows by 1 per column, by 2 per row and by 10 per direction. So its value
/// between pixels and between directions has a closed form.
int byteAt(int bin, int x, int y) { return 1 + x + 2 * y + 10 * bin; }

/// A table like ScoreTable, with kWidth x kHeight pixels.
class LinearTable {
 public:
  LinearTable() : pairs_(static_cast<size_t>(kBins) * (kHeight + 1) * (kWidth + 1) + 1) {
    for (int b = 0; b < kBins; ++b)
      for (int y = 0; y <= kHeight; ++y)
        for (int x = 0; x <= kWidth; ++x)
          at(b, x, y) = static_cast<uint16_t>(byteAt(b, x, y) | byteAt((b + 1) % kBins, x, y) << 8);
  }
  /// Marks a pixel as ignored.
  void ignore(int x, int y) {
    for (int b = 0; b < kBins; ++b) at(b, x, y) = 0;
    has_ignored_ = true;
  }
  KernelTable forKernel() const {
    return {pairs_.data(), kWidth + 1, kHeight + 1, kBins, has_ignored_, kScale, kOffset};
  }
  static constexpr float kScale = 0.05f, kOffset = -4;

 private:
  uint16_t& at(int bin, int x, int y) {
    return pairs_[(static_cast<size_t>(bin) * (kHeight + 1) + y) * (kWidth + 1) + x];
  }
  std::vector<uint16_t> pairs_;
  bool has_ignored_ = false;
};

/// Score of the LinearTable at a pixel, for a direction (du, dv) in the image.
double linearScore(double u, double v, double du, double dv) {
  if (dv < 0) {
    du = -du;
    dv = -dv;
  }
  // The diamond angle in [0, 2], see diamondAngle().
  const double angle = du >= 0 ? dv / (du + dv) : 2 - dv / (dv - du);
  const double bin = angle * kBins / 2, lower = std::floor(bin);
  const double a = std::fmod(lower, kBins), b = std::fmod(lower + 1, kBins), share = bin - lower;
  const double byte = 1 + u + 2 * v + 10 * ((1 - share) * a + share * b);
  return LinearTable::kOffset + LinearTable::kScale * byte;
}

KernelCamera forKernel(const CameraModel& camera) {
  KernelCamera k{};
  k.fx = static_cast<float>(camera.fx);
  k.fy = static_cast<float>(camera.fy);
  k.cx = static_cast<float>(camera.cx);
  k.cy = static_cast<float>(camera.cy);
  k.last_x = static_cast<float>(camera.width - 1);
  k.last_y = static_cast<float>(camera.height - 1);
  k.min_depth = static_cast<float>(CameraModel::kMinDepth);
  k.max_radius2 = static_cast<float>(camera.maxPlaneRadius2());
  k.distortion = static_cast<int>(camera.distortion);
  for (int i = 0; i < 8; ++i) k.k[i] = static_cast<float>(camera.coefficients[i]);
  const CameraModel::View& view = camera.view;
  const Eigen::Vector3d planes[] = {
      {1, 0, -view.x_min}, {-1, 0, view.x_max}, {0, 1, -view.y_min}, {0, -1, view.y_max}};
  for (int i = 0; i < 4; ++i)
    Eigen::Map<Eigen::Vector3f>(k.plane[i]) = planes[i].normalized().cast<float>();
  return k;
}

/// Work for the kernel, with the memory of its samples.
struct Work {
  std::vector<float> along;
  KernelBlock block;

  explicit Work(uint32_t cells = 1) { block.cells = cells; }

  /// Adds a segment. @param seen for each cell: visible samples, and 65535 times the weight in the
  /// high half
  void addSegment(const Eigen::Vector3d& centre, const Eigen::Vector3d& tangent,
                  const std::vector<float>& samples, const std::vector<uint32_t>& seen,
                  bool ends_group) {
    KernelBlock::Segment segment{};
    Eigen::Map<Eigen::Vector3d>(segment.centre) = centre;
    Eigen::Map<Eigen::Vector3f>(segment.tangent) = tangent.cast<float>();
    for (const float a : samples) segment.radius = std::max(segment.radius, std::abs(a));
    segment.first = static_cast<uint32_t>(along.size());
    for (const uint32_t s : seen) segment.samples |= s & 0xffffu;
    segment.ends_group = ends_group;
    along.insert(along.end(), samples.begin(), samples.end());
    block.segments.push_back(segment);
    block.seen.insert(block.seen.end(), seen.begin(), seen.end());
  }

  /// Sets the particles, T_map_camera, ordered by cell.
  void setParticles(const std::vector<Pose>& poses, const std::vector<int>& cells) {
    block.particles = poses.size();
    block.cell.clear();
    for (auto& plane : block.pose) plane.clear();
    for (auto& plane : block.rotation) plane.clear();
    constexpr size_t kLanes = KernelBlock::kLanePadding;
    for (size_t lane = 0; lane < (poses.size() + kLanes - 1) / kLanes * kLanes; ++lane) {
      const size_t p = std::min(lane, poses.size() - 1);
      const Pose to_camera = poses[p].inverse();
      block.cell.push_back(cells[p]);
      for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 3; ++c) {
          block.pose[3 * r + c].push_back(to_camera.linear()(r, c));
          block.rotation[3 * r + c].push_back(static_cast<float>(to_camera.linear()(r, c)));
        }
        block.pose[9 + r].push_back(to_camera.translation()[r]);
      }
    }
  }

  std::vector<KernelResult> run(const CameraModel& camera, const KernelLineRule& rule,
                                const LinearTable& table = LinearTable()) {
    block.along = along.data();
    std::vector<KernelResult> results(block.particles);
    runKernel(block, forKernel(camera), table.forKernel(), rule, results.data());
    return results;
  }
};

constexpr uint32_t kFullWeight = 65535u << 16;

/// Every sample has the weight 1: neither the border nor the spacing takes any away.
KernelLineRule unweighted(bool paper) { return {paper, 1 / 6.0f, 1e9f, 1e9f}; }

/// Sums of one particle, computed sample by sample in double precision.
KernelResult plainResult(const Work& work, const CameraModel& camera, const KernelLineRule& rule,
                         const Pose& pose, int cell) {
  const Pose to_camera = pose.inverse();
  double line_sum = 0, total_weight = 0, line_count = 0, score = 0, weight = 0;
  for (size_t s = 0; s < work.block.segments.size(); ++s) {
    const KernelBlock::Segment& segment = work.block.segments[s];
    const uint32_t seen = work.block.seen[s * work.block.cells + cell];
    const Eigen::Vector3d centre(segment.centre[0], segment.centre[1], segment.centre[2]);
    const Eigen::Vector3d tangent(segment.tangent[0], segment.tangent[1], segment.tangent[2]);
    for (uint32_t i = 0; i < 16; ++i) {
      if (!(seen >> i & 1u)) continue;
      const Eigen::Vector3d p =
          to_camera * (centre + double{work.along[segment.first + i]} * tangent);
      Eigen::Vector2d pixel;
      Eigen::Matrix<double, 2, 3> jacobian;
      if (!camera.project(p, &pixel, &jacobian) || !camera.contains(pixel)) continue;
      const Eigen::Vector2d way = jacobian * (to_camera.linear() * tangent);
      const double border = std::min(
          {pixel.x(), pixel.y(), camera.width - 1 - pixel.x(), camera.height - 1 - pixel.y()});
      const double spacing = rule.spacing_scale * way.lpNorm<1>() * (rule.paper ? p.z() : 1);
      const double w = (seen >> 16) / 65535.0 * std::min(1.0, border * rule.inverse_fade) *
                       std::min(1.0, spacing);
      weight += w;
      score += w * linearScore(pixel.x(), pixel.y(), way.x(), way.y());
    }
    if (!segment.ends_group) continue;
    const double saturation = weight * rule.inverse_saturation;
    line_sum += rule.paper ? score / std::max(1.0, weight) : score / (1 + saturation);
    line_count += rule.paper ? std::min(1.0, weight) : saturation / (1 + saturation);
    total_weight += weight;
    score = weight = 0;
  }
  return {line_sum, static_cast<float>(total_weight), static_cast<float>(line_count)};
}

/// Forty segments in front of the camera, seen from two cells. Some of them lie outside the image.
Work randomWork(RandomSource* random) {
  Work work(2);
  for (int s = 0; s < 40; ++s) {
    const Eigen::Vector3d centre(2.4 * random->uniform() - 1.2, 1.6 * random->uniform() - 0.8,
                                 1 + 2 * random->uniform());
    std::vector<float> samples(1 + static_cast<size_t>(16 * random->uniform()));
    for (size_t i = 0; i < samples.size(); ++i)
      samples[i] = 0.03f * (static_cast<float>(i) - static_cast<float>(samples.size()) / 2);
    std::vector<uint32_t> seen;
    for (int c = 0; c < 2; ++c) {
      const auto bits = static_cast<uint32_t>(65536 * random->uniform());
      const auto facing = static_cast<uint32_t>(65536 * random->uniform());
      seen.push_back((bits & ((1u << samples.size()) - 1)) | facing << 16);
    }
    work.addSegment(centre, random->direction(), samples, seen, s == 39 || s % 3 == 1);
  }
  return work;
}

class CpuKernelOf : public testing::TestWithParam<std::tuple<DistortionModel, bool>> {};

/// The truth is plainResult() in double precision. A sum has some 100 samples. In single precision
/// the score of a sample has an error of about 1e-6 (1e-5 px, 2 bytes per pixel, 0.05 per byte).
/// The error is larger where an edge is seen nearly end-on, because its direction is then a small
/// difference.
TEST_P(CpuKernelOf, AgreesWithPlainSums) {
  const auto [distortion, paper] = GetParam();
  const CameraModel camera = test::distorted(smallCamera(), distortion);
  RandomSource random(6);
  Work work = randomWork(&random);
  std::vector<Pose> poses;
  std::vector<int> cells;
  for (int i = 0; i < 53; ++i) {  // neither a multiple of 16 nor of one cell
    poses.push_back(expSe3(0.1 * random.normalTwist()));
    cells.push_back(i < 21 ? 0 : 1);
  }
  work.setParticles(poses, cells);
  const KernelLineRule rule{paper, 1 / 6.0f, 1 / 4.0f, paper ? 0.3f : 0.01f};
  const std::vector<KernelResult> results = work.run(camera, rule);
  for (size_t i = 0; i < poses.size(); ++i) {
    const KernelResult truth = plainResult(work, camera, rule, poses[i], cells[i]);
    ASSERT_GT(truth.sample_weight, 1);
    EXPECT_NEAR(results[i].line_sum, truth.line_sum, 1e-4);
    EXPECT_NEAR(results[i].sample_weight, truth.sample_weight, 1e-4);
    EXPECT_NEAR(results[i].line_count, truth.line_count, 1e-5);
  }
}

INSTANTIATE_TEST_SUITE_P(All, CpuKernelOf,
                         testing::Combine(testing::Values(DistortionModel::kNone,
                                                          DistortionModel::kPlumbBob,
                                                          DistortionModel::kRationalPolynomial,
                                                          DistortionModel::kEquidistant),
                                          testing::Bool()));

/// A particle adds its samples in the same order whatever its neighbours are, so the bits are
/// equal.
TEST(CpuKernel, AParticleAloneHasTheSameBitsAsInABlock) {
  RandomSource random(7);
  Work work = randomWork(&random);
  std::vector<Pose> poses;
  poses.reserve(37);
  for (int i = 0; i < 37; ++i) poses.push_back(expSe3(0.1 * random.normalTwist()));
  work.setParticles(poses, std::vector<int>(poses.size(), 1));
  const KernelLineRule rule{false, 1 / 6.0f, 1 / 4.0f, 0.01f};
  const std::vector<KernelResult> together = work.run(smallCamera(), rule);
  for (size_t i = 0; i < poses.size(); ++i) {
    work.setParticles({poses[i]}, {1});
    const KernelResult alone = work.run(smallCamera(), rule).front();
    EXPECT_EQ(alone.line_sum, together[i].line_sum);
    EXPECT_EQ(alone.sample_weight, together[i].sample_weight);
    EXPECT_EQ(alone.line_count, together[i].line_count);
  }
}

/// Score of a horizontal line at a pixel.
double horizontalScore(double u, double v) { return linearScore(u, v, 1, 0); }

/// Adds a horizontal line at the depth 1 m, with samples at the given columns of one image row.
void addRow(Work* work, double row, const std::vector<double>& columns, bool ends_group) {
  std::vector<float> along;
  along.reserve(columns.size());
  for (const double u : columns) along.push_back(static_cast<float>((u - 29.5) / 50));
  work->addSegment({0, (row - 19.5) / 50, 1}, {1, 0, 0}, along,
                   {((1u << columns.size()) - 1) | kFullWeight}, ends_group);
}

/// Two lines of three samples and of one sample. The sums are worked out by hand. The tolerance is
/// single precision.
TEST(CpuKernel, LinesAreClosedByTheRuleOfTheirModel) {
  Work work;
  addRow(&work, 10, {20, 30}, false);  // two segments of one line
  addRow(&work, 10, {40}, true);
  addRow(&work, 25.5, {12.25}, true);
  work.setParticles({Pose::Identity()}, {0});
  const double first = horizontalScore(20, 10) + horizontalScore(30, 10) + horizontalScore(40, 10);
  const double second = horizontalScore(12.25, 25.5);
  const KernelResult paper = work.run(smallCamera(), unweighted(true)).front();
  EXPECT_NEAR(paper.line_sum, first / 3 + second, 1e-4);
  EXPECT_NEAR(paper.line_count, 2, 1e-6);
  EXPECT_NEAR(paper.sample_weight, 4, 1e-6);
  const KernelResult robust = work.run(smallCamera(), unweighted(false)).front();
  EXPECT_NEAR(robust.line_sum, first / (1 + 3 / 6.0) + second / (1 + 1 / 6.0), 1e-4);
  EXPECT_NEAR(robust.line_count, 3 / 9.0 + 1 / 7.0, 1e-6);
  EXPECT_NEAR(robust.sample_weight, 4, 1e-6);
}

/// Over the last 4 px before the border the weight falls to 0.
TEST(CpuKernel, TheWeightFadesTowardsTheBorder) {
  KernelLineRule rule = unweighted(true);
  rule.inverse_fade = 1 / 4.0f;
  for (const auto& [u, v, weight] : {std::tuple{1.0, 20.0, 0.25},
                                     {57.0, 20.0, 0.5},
                                     {30.0, 3.0, 0.75},
                                     {30.0, 39.0, 0.0},
                                     {30.0, 20.0, 1.0}}) {
    Work work;
    addRow(&work, v, {u}, true);
    work.setParticles({Pose::Identity()}, {0});
    EXPECT_NEAR(work.run(smallCamera(), rule).front().sample_weight, weight, 1e-5);
  }
}

/// The line moves 50 px per metre at the depth 1 m, and 25 px per metre at the depth 2 m. In the
/// paper's model the product with the depth counts.
TEST(CpuKernel, TheWeightIsTheSpacingOfTheSamples) {
  for (const double depth : {1.0, 2.0}) {
    Work work;
    work.addSegment({0, 0, depth}, {1, 0, 0}, {0}, {1u | kFullWeight}, true);
    work.setParticles({Pose::Identity()}, {0});
    KernelLineRule rule = unweighted(false);
    rule.spacing_scale = 0.01f;
    EXPECT_NEAR(work.run(smallCamera(), rule).front().sample_weight, 0.5 / depth, 1e-6);
    rule.paper = true;
    EXPECT_NEAR(work.run(smallCamera(), rule).front().sample_weight, 0.5, 1e-6);
  }
}

TEST(CpuKernel, ASampleBesideAnIgnoredPixelDoesNotCount) {
  LinearTable table;
  table.ignore(30, 20);
  for (const auto& [u, v, counts] : {std::tuple{29.3, 19.6, false},
                                     {30.4, 20.0, false},
                                     {30.2, 20.7, false},
                                     {29.8, 20.5, false},
                                     {31.2, 20.0, true},
                                     {30.0, 18.5, true}}) {
    Work work;
    addRow(&work, v, {u}, true);
    work.setParticles({Pose::Identity()}, {0});
    const KernelResult result = work.run(smallCamera(), unweighted(true), table).front();
    EXPECT_EQ(result.sample_weight, counts ? 1 : 0) << u << ", " << v;
    EXPECT_NEAR(result.line_sum, counts ? horizontalScore(u, v) : 0, 1e-5);
  }
}

/// A particle whose samples are all outside the image, behind the camera or too near sums up to
/// exactly zero. A neighbour that sees them is not disturbed.
TEST(CpuKernel, WhatIsNotInTheImageSumsUpToZero) {
  Work work;
  addRow(&work, 20, {20, 30, 40}, true);
  const auto moved = [](double x, double y, double z) {
    return Pose(Eigen::Translation3d(x, y, z));
  };
  Pose backward = Pose::Identity();
  backward.linear() = rotationFromAngles(0, M_PI, 0);
  const std::vector<Pose> blind = {moved(5, 0, 0), moved(0, -5, 0), moved(0, 0, 1.5),
                                   moved(0, 0, 0.995), backward};
  for (const Pose& pose : blind) {
    work.setParticles({Pose::Identity(), pose, Pose::Identity()}, {0, 0, 0});
    const std::vector<KernelResult> results = work.run(smallCamera(), unweighted(false));
    EXPECT_EQ(results[1].line_sum, 0);
    EXPECT_EQ(results[1].sample_weight, 0);
    EXPECT_EQ(results[1].line_count, 0);
    for (const size_t i : {0, 2}) EXPECT_NEAR(results[i].sample_weight, 3, 1e-6);
  }
}

TEST(CpuKernel, NamesItsInstructionSet) { EXPECT_FALSE(std::string(kernelTargetName()).empty()); }

}  // namespace
}  // namespace edge_mcl
