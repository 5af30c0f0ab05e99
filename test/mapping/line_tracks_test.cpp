#include "edge_mcl/mapping/line_tracks.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "edge_mcl/core/base/random_source.h"

namespace edge_mcl {
namespace {

/// Segments of a line as cameras see it that stand 2 m away, side by side.
class LineInImages {
 public:
  LineInImages(Eigen::Vector3d start, Eigen::Vector3d end, uint64_t seed)
      : start_(std::move(start)), end_(std::move(end)), random_(seed) {}

  /// @param pixel_sigma noise across the segment at both ends, px; depth_sigma noise of depths, m.
  void add(uint32_t image, double pixel_sigma, double depth_sigma,
           std::vector<DepthSegment>* segments) {
    DepthSegment s;
    s.image = image;
    // Looks along y. The cameras stand at several places and heights.
    s.T_map_camera.linear() << 1, 0, 0, 0, 0, 1, 0, -1, 0;
    s.T_map_camera.translation() =
        Eigen::Vector3d(0.3 * image - 0.6, -2, 1 + 0.25 * static_cast<double>(image % 3));
    const auto seen = [&](const Eigen::Vector3d& point, Eigen::Vector3d* ray,
                          Eigen::Vector3d* end) {
      const Eigen::Vector3d in_camera = s.T_map_camera.inverse() * point;
      *ray = in_camera / in_camera.z();
      ray->x() += pixel_sigma / kFocal * random_.normal();
      ray->y() += pixel_sigma / kFocal * random_.normal();
      *end =
          s.T_map_camera * Eigen::Vector3d(*ray * (in_camera.z() + depth_sigma * random_.normal()));
    };
    seen(start_, &s.ray_start, &s.start);
    seen(end_, &s.ray_end, &s.end);
    segments->push_back(s);
  }
  double distance(const Eigen::Vector3d& point) const {
    return (point - start_).cross(end_ - start_).norm() / (end_ - start_).norm();
  }
  static constexpr double kFocal = 525;

 private:
  Eigen::Vector3d start_, end_;
  RandomSource random_;
};

/// The truth is the line. Over 100 seeds the error in its middle must fit the standard deviation
/// that is told: a root mean square of 0.5 to 1.5 of it for two axes, of which the worse is told.
TEST(LineTracks, FindTheLineAndItsError) {
  double sum = 0;
  for (uint64_t seed = 1; seed <= 100; ++seed) {
    LineInImages truth({-0.5, 0, 1.2}, {0.4, 0.1, 1.3}, seed);
    std::vector<DepthSegment> segments;
    for (uint32_t i = 0; i < 6; ++i) truth.add(i, 1, 0.004, &segments);
    TrackOptions options;
    options.focal = LineInImages::kFocal;
    options.pixel_sigma = 1;
    const auto lines = trackLines(segments, options);
    ASSERT_EQ(lines.size(), 1u) << seed;
    EXPECT_EQ(lines[0].views, 6u);
    EXPECT_NEAR((lines[0].end - lines[0].start).norm(), 0.91, 0.06);
    const double error = truth.distance((lines[0].start + lines[0].end) / 2);
    EXPECT_LT(error, 0.05) << seed;  // four times the largest standard deviation that is told
    sum += std::pow(error / lines[0].sigma, 2);
  }
  EXPECT_GT(std::sqrt(sum / 100), 0.5);
  EXPECT_LT(std::sqrt(sum / 100), 1.5);
}

TEST(LineTracks, ALineNeedsViews) {
  LineInImages truth({-0.5, 0, 1.2}, {0.4, 0.1, 1.3}, 1);
  std::vector<DepthSegment> segments;
  for (uint32_t i = 0; i < 3; ++i) truth.add(i, 0, 0, &segments);
  EXPECT_TRUE(trackLines(segments, {}).empty());
  truth.add(2, 0, 0, &segments);  // the same image again
  EXPECT_TRUE(trackLines(segments, {}).empty());
  truth.add(3, 0, 0, &segments);
  const auto lines = trackLines(segments, {});
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_LT(truth.distance(lines[0].start), 1e-4);
  EXPECT_LT(truth.distance(lines[0].end), 1e-4);
  EXPECT_TRUE(trackLines({}, {}).empty());
}

/// Two edges of a shelf board are 2 cm apart and stay two lines. A line 1 cm beside another one is
/// a copy of it.
TEST(LineTracks, CopiesAreDropped) {
  for (const auto& [distance, count] : {std::pair(0.04, size_t{2}), std::pair(0.01, size_t{1})}) {
    std::vector<DepthSegment> segments;
    LineInImages a({-0.5, 0, 1.2}, {0.5, 0, 1.2}, 1),
        b({-0.5, 0, 1.2 + distance}, {0.5, 0, 1.2 + distance}, 2);
    for (uint32_t i = 0; i < 5; ++i) {
      a.add(i, 0, 0, &segments);
      b.add(i, 0, 0, &segments);
    }
    EXPECT_EQ(trackLines(segments, {}).size(), count) << distance;
  }
}

/// A piece that only one image has seen is cut off.
TEST(LineTracks, KeepThePieceThatEnoughImagesHaveSeen) {
  std::vector<DepthSegment> segments;
  LineInImages common({-0.5, 0, 1.2}, {0.5, 0, 1.2}, 1), longer({-0.5, 0, 1.2}, {1.5, 0, 1.2}, 2);
  for (uint32_t i = 0; i < 5; ++i) common.add(i, 0, 0, &segments);
  longer.add(5, 0, 0, &segments);
  const auto lines = trackLines(segments, {});
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_NEAR((lines[0].end - lines[0].start).norm(), 1, 0.03);  // the pieces are counted by 2 cm
}

}  // namespace
}  // namespace edge_mcl
