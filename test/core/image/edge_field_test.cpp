#include "edge_mcl/core/image/edge_field.h"

#include <gtest/gtest.h>

#include "edge_mcl/core/base/random_source.h"
#include "edge_mcl/core/image/image_edges.h"
#include "support/scenes.h"

namespace edge_mcl {
namespace {

/// The diamond angle grows with the angle. Both directions of a line have the same diamond angle.
/// diamondDirection() is its inverse.
TEST(EdgeField, DiamondAngleIsAMonotoneStandInForTheAngle) {
  double last = -1;
  for (int k = 0; k < 180; ++k) {
    const double p = diamondAngle(std::cos(k * M_PI / 180), std::sin(k * M_PI / 180));
    EXPECT_GT(p, last);
    last = p;
    EXPECT_NEAR(diamondAngle(-std::cos(k * M_PI / 180), -std::sin(k * M_PI / 180)), p, 1e-12);
    const Eigen::Vector2d d = diamondDirection(p);
    EXPECT_NEAR(std::abs(d.x() * std::sin(k * M_PI / 180) - d.y() * std::cos(k * M_PI / 180)), 0,
                1e-9);
  }
}

/// The table is compared with the direct search along the normal, in a picture of a furnished room.
TEST(EdgeField, AgreesWithTheDirectSearch) {
  const MeshModel mesh = test::furnishedRooms();
  const CameraModel camera = test::pinhole(320, 240, 250);
  const cv::Mat picture =
      test::render(mesh, camera, test::lookAlong({3.2, 2.5, 1.4}, {-1, -0.5, -0.15}), 1);
  ImageParameters params;
  const EdgeImage image = findEdges(picture, {}, params, "room");
  ASSERT_GT(image.edgeCount(), 1000u);
  const EdgeField field(image, EdgePixels(image), params);
  const double tolerance = std::cos(params.orientation_tolerance_deg * M_PI / 180);
  RandomSource random(8);
  int good = 0, total = 0;
  for (int i = 0; i < 20000; ++i) {
    const int bin = static_cast<int>(random.uniform() * field.bins());
    const int x = static_cast<int>(random.uniform() * 320),
              y = static_cast<int>(random.uniform() * 240);
    const Eigen::Vector2d direction = diamondDirection(2.0 * bin / field.bins());
    const NormalHit hit =
        searchAlongNormal(image, Eigen::Vector2d(x, y), {-direction.y(), direction.x()},
                          params.search_length, tolerance);
    const double table = field.distance(bin, x, y);
    ++total;
    if (!hit.found && std::isinf(table))
      ++good;
    else if (hit.found && !std::isinf(table))
      good += std::abs(std::abs(hit.distance) - table) <= 1;
    else  // one of them finds no edge: rounding explains this at the end of the reach only
      good += (hit.found ? std::abs(hit.distance) : table) > params.search_length - 1.5;
  }
  std::printf("table agrees with the direct search within 1 px for %.2f %% of samples\n",
              100.0 * good / total);
  EXPECT_GT(good, 0.99 * total);
}

}  // namespace
}  // namespace edge_mcl
