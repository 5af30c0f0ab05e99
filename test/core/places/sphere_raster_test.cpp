#include "edge_mcl/core/places/sphere_raster.h"

#include <gtest/gtest.h>

#include "edge_mcl/core/base/angles.h"

namespace edge_mcl {
namespace {

TEST(SphereRaster, DirectionsComeBackToTheirBit) {
  for (int axis = 0; axis < 3; ++axis)
    for (int row = 0; row < raster::kAround; row += 7)
      for (int bit = 0; bit < raster::kAlong; bit += 5) {
        const Eigen::Vector3d v = 3 * raster::directionAt(row, bit, axis);
        EXPECT_EQ(raster::rowOf(v, axis), row);
        const double along = raster::alongOf(v, axis);
        EXPECT_EQ(raster::bitsOf(along, along), uint64_t{1} << bit);
      }
}

TEST(SphereRaster, AnglesAreThoseOfTheAxis) {
  EXPECT_NEAR(raster::alongOf({0, 0, 2}, 2), 0, 1e-12);
  EXPECT_NEAR(raster::alongOf({1, 0, 0}, 2), M_PI / 2, 1e-12);
  EXPECT_NEAR(raster::alongOf({1, 0, -1}, 2), 0.75 * M_PI, 1e-12);
  // A quarter turn about the axis is a quarter of the rows.
  EXPECT_EQ((raster::rowOf({0.1, 1, 0}, 2) - raster::rowOf({1, -0.1, 0}, 2) + raster::kAround) %
                raster::kAround,
            raster::kAround / 4);
}

TEST(SphereRaster, ARangeHasAllBitsBetweenItsEnds) {
  EXPECT_EQ(raster::bitsOf(0, M_PI), ~uint64_t{0});
  EXPECT_EQ(raster::bitsOf(2.5 * raster::kBit, 4.5 * raster::kBit), uint64_t{0b11100});
  EXPECT_EQ(raster::bitsOf(4.5 * raster::kBit, 2.5 * raster::kBit), uint64_t{0b11100});
  EXPECT_EQ(raster::bitsOf(-1, 0.5 * raster::kBit), uint64_t{1});
  EXPECT_EQ(raster::bitsOf(M_PI - 1e-9, 4), uint64_t{1} << 63);
}

}  // namespace
}  // namespace edge_mcl
