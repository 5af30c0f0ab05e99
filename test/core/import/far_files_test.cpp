// Files whose far coordinates are written in an unusual way. All of them must keep their shape.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "core/import/model_files.h"
#include "edge_mcl/core/import/mesh_loader.h"

namespace edge_mcl {
namespace {

using test::replaced;
using test::textOf;
using test::writeFile;

Eigen::Vector3d sizeOf(const std::string& file, const MapParameters& params = {}) {
  const MeshModel mesh = loadMesh(file, params);
  return (mesh.highest - mesh.lowest).cast<double>();
}

/// A triangle of 6 x 4 x 2.7 m in millimetres, 12 m from the origin of the file. What the program
/// that moves vertices does not understand, an importer may.
TEST(FarFiles, NoVertexStaysBehind) {
  MapParameters params;
  params.scale = 0.001;
  const std::string ply =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
      "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";
  const std::string face = "f 1 2 3\n";
  for (const auto& [name, text] : std::vector<std::pair<std::string, std::string>>{
           {"plain.obj", "v 12000 9000 0\nv 18000 9000 0\nv 18000 13000 2700\n" + face},
           {"plus.obj", "v +12000 +9000 0\nv 18000 9000 0\nv 18000 13000 2700\n" + face},
           {"going_on.obj", "v 12000 9000 0\nv 18000 9000 0\nv 18000 13000 \\\n2700\n" + face},
           {"tiny.obj", "v 12000 9000 1e-400\nv 18000 9000 0\nv 18000 13000 2700\n" + face},
           {"empty_lines.ply", ply + "12000 9000 0\n\n18000 9000 0\n18000 13000 2700\n3 0 1 2\n"}})
    EXPECT_LT((sizeOf(writeFile(name, text), params) - Eigen::Vector3d(6, 4, 2.7)).norm(), 1e-5)
        << name;
}

/// The truth is box.ifc, 4 x 3 x 2.5 m at the origin. A point that nothing refers to is no place.
TEST(FarFiles, AFarPointOfAnIfcFileIsNotAlwaysItsPlace) {
  const std::string text = textOf(EDGE_MCL_TEST_DATA "box.ifc");
  const MeshModel box = loadMesh(
      writeFile("far_point.ifc", replaced(text, "#15=IFCLOCALPLACEMENT",
                                          "#30=IFCCARTESIANPOINT((500123.4,5400321.7,312.));\n"
                                          "#15=IFCLOCALPLACEMENT")),
      {});
  EXPECT_TRUE(box.origin.isZero());
  EXPECT_LT((box.lowest - Eigen::Vector3f(-2, -1.5f, 0)).norm(), 1e-5f);
  EXPECT_LT((box.highest - Eigen::Vector3f(2, 1.5f, 2.5f)).norm(), 1e-5f);
}

/// A triangle with the corners (0 0 0), (2 0 0), (0 1 3) in millimetres, 100 m from the origin of
/// the file, under a node that scales it to metres.
TEST(FarFiles, ANodeOfColladaMayScale) {
  const std::string text = replaced(textOf(EDGE_MCL_TEST_DATA "z_up.dae"), "0 0 0 2 0 0 0 1 3",
                                    "100000 0 0 102000 0 0 100000 1000 3000");
  const size_t node = text.find("<instance_geometry");
  ASSERT_NE(node, std::string::npos);
  std::string scaled = text;
  scaled.insert(node, "<scale>0.001 0.001 0.001</scale>");
  const MeshModel mesh = loadMesh(writeFile("scaled.dae", scaled), {});
  EXPECT_LT((mesh.highest - mesh.lowest - Eigen::Vector3f(2, 1, 3)).norm(), 1e-4f);
  EXPECT_LT((mesh.origin + mesh.lowest.cast<double>() - Eigen::Vector3d(100, 0, 0)).norm(), 1e-4);
  EXPECT_TRUE(mesh.report.warnings.empty());
}

TEST(FarFiles, AnObjectInAnotherCountryIsTold) {
  const MeshModel mesh =
      loadMesh(writeFile("two_places.obj",
                         "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\nv 2 0 0\nv 3 0 0\nv 3 1 0\nf 4 5 6\n"
                         "v 500000 0 0\nv 500001 0 0\nv 500001 1 0\nf 7 8 9\n"),
               {});
  std::string all;
  for (const std::string& warning : mesh.report.warnings) all += warning;
  EXPECT_NE(all.find("3 of 9 vertices are rounded"), std::string::npos) << all;
  EXPECT_NE(all.find("500 km"), std::string::npos) << all;
}

TEST(FarFiles, AnOriginFarFromTheModelIsTold) {
  MapParameters params;
  params.origin = "500000,0,0";
  const MeshModel mesh =
      loadMesh(writeFile("near.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n"), params);
  ASSERT_FALSE(mesh.report.warnings.empty());
  EXPECT_NE(mesh.report.warnings.back().find("map.origin"), std::string::npos);
}

TEST(FarFiles, UnitsInCommentsAndBetweenTabsAreRead) {
  const std::string text = textOf(EDGE_MCL_TEST_DATA "z_up.dae");
  const std::string unit = "<unit name=\"meter\" meter=\"1\"/>";
  EXPECT_EQ(
      loadMesh(writeFile("comment.dae", replaced(text, unit,
                                                 "<!-- <unit meter=\"0.3048\" name=\"foot\"/> -->"
                                                 "<unit\tmeter=\"0.0254\"\tname=\"inch\"/>")),
               {})
          .report.unit,
      "inch");
}

/// The end of the first solid is not the end of the file.
TEST(FarFiles, TheSecondSolidOfAnStlFileMayBeCutOff) {
  const std::string facet =
      "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n"
      "vertex 0 1 0\nendloop\nendfacet\n";
  const auto isTold = [](const std::string& text) {
    for (const std::string& w : loadMesh(writeFile("solids.stl", text), {}).report.warnings)
      if (w.find("cut off") != std::string::npos) return true;
    return false;
  };
  const std::string one = "solid a\n" + facet + "endsolid a\n";
  EXPECT_FALSE(isTold(one));
  EXPECT_TRUE(isTold(one + "solid b\n" + facet));
}

}  // namespace
}  // namespace edge_mcl
