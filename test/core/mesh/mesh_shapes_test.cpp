#include "edge_mcl/core/mesh/mesh_shapes.h"

#include <gtest/gtest.h>

#include "support/scenes.h"

namespace edge_mcl {
namespace {

TEST(MeshShapes, BoxesApartAreShapesOfTheirOwn) {
  MeshSoup soup;
  test::addBox(&soup, {0, 0, 0}, {1, 1, 1});
  test::addBox(&soup, {2, 0, 0}, {3, 2, 1});
  const MeshShapes shapes = findShapes(weldMesh(std::move(soup), 1e-6, "test"));
  ASSERT_EQ(shapes.count(), 2u);
  for (size_t t = 0; t < shapes.of_triangle.size(); ++t)
    EXPECT_EQ(shapes.of_triangle[t], t < 12 ? 0u : 1u);
  EXPECT_EQ(shapes.box[1].min(), Eigen::Vector3f(2, 0, 0));
  EXPECT_EQ(shapes.box[1].max(), Eigen::Vector3f(3, 2, 1));
}

TEST(MeshShapes, BoxesThatTouchAtACornerOrAnEdgeAreTwo) {
  for (const Eigen::Vector3f& at : {Eigen::Vector3f(1, 1, 1), Eigen::Vector3f(1, 1, 0)}) {
    MeshSoup soup;
    test::addBox(&soup, {0, 0, 0}, {1, 1, 1});
    test::addBox(&soup, at, at + Eigen::Vector3f(1, 1, 1));
    EXPECT_EQ(findShapes(weldMesh(std::move(soup), 1e-6, "test")).count(), 2u);
  }
}

TEST(MeshShapes, AModelOfLinesHasNone) {
  MeshSoup soup;
  soup.vertices = {{0, 0, 0}, {1, 0, 0}};
  soup.lines = {{0, 1}};
  EXPECT_EQ(findShapes(weldMesh(std::move(soup), 1e-6, "test")).count(), 0u);
}

}  // namespace
}  // namespace edge_mcl
