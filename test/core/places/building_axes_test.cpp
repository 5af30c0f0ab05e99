#include "edge_mcl/core/places/building_axes.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "edge_mcl/core/base/angles.h"
#include "support/scenes.h"

namespace edge_mcl {
namespace {

TEST(BuildingAxes, FollowTheWallsOfATurnedBuilding) {
  for (const double degrees : {0.0, 20.0, 45.0, 77.0}) {
    MeshModel mesh = test::furnishedRooms();
    const Eigen::Matrix3f turn =
        Eigen::AngleAxisf(static_cast<float>(degrees * kDegree), Eigen::Vector3f::UnitZ())
            .toRotationMatrix();
    for (Eigen::Vector3f& v : mesh.vertices) v = turn * v;
    const EdgeModel model = buildEdgeModel(&mesh, {});
    const auto axes = buildingAxes(model);
    ASSERT_TRUE(axes) << degrees;
    EXPECT_NEAR(axes->share, 1, 0.01);
    EXPECT_NEAR(axes->R_map_building.determinant(), 1, 1e-9);
    EXPECT_TRUE(axes->R_map_building.col(2).isApprox(Eigen::Vector3d::UnitZ(), 1e-9));
    const Eigen::Vector3d along =
        turn.cast<double>().transpose() * axes->R_map_building.col(0).eval();
    EXPECT_NEAR(along.cwiseAbs().maxCoeff(), 1, 1e-5) << degrees;
  }
}

TEST(BuildingAxes, ARoundBuildingHasNone) {
  MeshModel mesh = test::column(24, 4.0f, 1.0f);
  EXPECT_FALSE(buildingAxes(buildEdgeModel(&mesh, {})));
}

}  // namespace
}  // namespace edge_mcl
