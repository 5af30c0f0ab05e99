#include <assimp/version.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <map>
#include <sstream>
#include <string>
#include <tuple>
#include <utility>

#include "core/import/model_files.h"
#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/import/mesh_loader.h"
#include "edge_mcl/core/mesh/mesh_model.h"

namespace edge_mcl {
namespace {

using test::errorOf;
using test::replaced;
using test::textOf;
using test::writeFile;

/// Every error is one line that names the file.
TEST(EdgeModel, BadModelFilesAreOneLineErrors) {
  const auto expectError = [](const std::string& file) {
    try {
      loadMesh(file, {});
      FAIL() << file << ": no error";
    } catch (const InputError& e) {
      EXPECT_NE(std::string(e.what()).find(file), std::string::npos) << e.what();
      EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos) << e.what();
    }
  };
  expectError("/does/not/exist.obj");
  expectError(writeFile("empty.obj", ""));
  expectError(writeFile("text.obj", "this is no model\n"));
  expectError(writeFile("points.obj", "v 0 0 0\nv 1 1 1\n"));
  expectError(writeFile("nan.obj", "v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"));
  expectError(writeFile("absurd.obj", "v 1e30 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"));
  expectError(writeFile("index.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 7\n"));
  expectError(writeFile("flat.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n"));
  expectError(writeFile("truncated.stl", std::string("solid\0", 6) + std::string(90, 'x')));
  // Without the end of the header assimp would search for it forever.
  expectError(
      writeFile("endless.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\n0\n"));
  expectError(writeFile("broken_header.ply", std::string("ply\nformat ascii 1.0\nel\0eme", 27)));
  expectError(writeFile("wrong_type.ply",
                        "ply\nformat ascii 1.0\nelement vertex 1\n"
                        "property real x\nend_header\n0\n"));
  expectError(testing::TempDir());
}

TEST(EdgeModel, ScaleAndTransformAreApplied) {
  MapParameters params;
  params.scale = 0.001;
  params.x = 5;
  params.yaw_deg = 90;
  const std::string file = writeFile("mm.obj", "v 0 0 0\nv 1000 0 0\nl 1 2\n");
  const MeshModel mesh = loadMesh(file, params);
  EXPECT_LT((mesh.lowest - Eigen::Vector3f(5, 0, 0)).norm(), 1e-5f);
  EXPECT_LT((mesh.highest - Eigen::Vector3f(5, 1, 0)).norm(), 1e-5f);
}

/// The file has one face without vertices and two triangles.
TEST(MeshLoader, AFaceWithoutVerticesIsDropped) {
  const MeshModel mesh = loadMesh(
      writeFile("empty_face.ply",
                "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
                "property float z\nelement face 3\nproperty list uchar int vertex_indices\n"
                "end_header\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n0\n3 0 1 2\n3 0 2 3\n"),
      {});
  EXPECT_EQ(mesh.triangles.size(), 2u);
  EXPECT_EQ(mesh.report.degenerate_triangles, 1u);
}

TEST(MeshLoader, WhatCannotBeReadIsNamedWithAWayOn) {
  const std::string ifc4 = writeFile(
      "new.ifc", replaced(textOf(EDGE_MCL_TEST_DATA "box.ifc"), "'IFC2X3'", "'IFC4X3_ADD2'"));
  EXPECT_NE(errorOf(ifc4).find("IFC4X3_ADD2"), std::string::npos);
  EXPECT_NE(errorOf(ifc4).find("IfcConvert"), std::string::npos);
  EXPECT_NE(errorOf(writeFile("a.FCStd", "PK")).find("exports an OBJ"), std::string::npos);
  const std::string strips = writeFile("strips.ply",
                                       "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\n"
                                       "element tristrips 1\nproperty list int int vertex_indices\n"
                                       "end_header\n0\n3 0 0 0\n");
  EXPECT_NE(errorOf(strips).find("triangle strips"), std::string::npos);
}

/// assimp 5.2 reads a null pointer when an IFC2X3 file holds this entity of IFC4.
TEST(MeshLoader, AnImporterThatCrashesIsOneError) {
  if (aiGetVersionMajor() > 5 || aiGetVersionMinor() >= 4)
    GTEST_SKIP() << "assimp 5.4 and later do not crash with this file";
  const std::string crash = writeFile(
      "crash.ifc",
      replaced(textOf(EDGE_MCL_TEST_DATA "box.ifc"), "#21=IFCEXTRUDEDAREASOLID(#20,#9,#7,2.5);",
               "#21=IFCPOLYGONALFACESET(#40,$,(#41),$);\n#40=IFCCARTESIANPOINTLIST3D(((0.,0.,0.),"
               "(1.,0.,0.),(0.,1.,0.)));\n#41=IFCINDEXEDPOLYGONALFACE((1,2,3));"));
  const std::string error = errorOf(crash);
  EXPECT_NE(error.find("crashed"), std::string::npos) << error;
}

TEST(MeshLoader, AnImportHasLimitsOfTimeAndMemory) {
  const std::string file = EDGE_MCL_TEST_DATA "box.ifc";
  MapParameters params;
  params.import_seconds = 1e-6;
  EXPECT_NE(errorOf(file, params).find("import_seconds"), std::string::npos);
  params = {};
  params.import_gigabytes = 1e-3;
  const std::string error = errorOf(file, params);
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  EXPECT_NE(error.find("import_gigabytes"), std::string::npos) << error;
#endif
}

TEST(MeshLoader, ObjectsAreChosenByName) {
  const std::string file = writeFile("objects.obj",
                                     "o Wall_1\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
                                     "o Office_chair\nv 0 0 5\nv 1 0 5\nv 0 1 5\nf 4 5 6\n");
  MapParameters params;
  EXPECT_EQ(loadMesh(file, params).report.objects.size(), 2u);
  params.exclude = " *chair*";
  EXPECT_EQ(loadMesh(file, params).highest.z(), 0);
  params.exclude = "";
  params.include = "nothing, office*";
  EXPECT_NE(errorOf(file, params).find("nothing"), std::string::npos);
  params.include = "office*";
  EXPECT_EQ(loadMesh(file, params).lowest.z(), 5);
  params.exclude = "*";
  EXPECT_NE(errorOf(file, params).find("leave nothing"), std::string::npos);
}

/// Names of building models hold spaces and brackets.
TEST(MeshLoader, NamesAreTakenAsTheyAre) {
  const std::string face = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf -1 -2 -3\n";
  const std::string file =
      writeFile("names.obj", "o Basic Wall [200]\n" + face + "o Basic Wall [300]\r\n" + face +
                                 "o Door\n" + face);
  MapParameters params;
  const std::map<std::string, size_t> objects = loadMesh(file, params).report.objects;
  EXPECT_EQ(objects.count("Basic_Wall_[200]"), 1u);
  EXPECT_EQ(objects.count("Basic_Wall_[300]"), 1u);
  params.include = "*[200]";
  EXPECT_EQ(loadMesh(file, params).report.objects.size(), 1u);
  params.include = "basic?wall*";
  EXPECT_EQ(loadMesh(file, params).report.objects.size(), 2u);
}

TEST(MeshLoader, AMirroredAxisIsTurnedBack) {
  MapParameters params;
  params.mirror = "y";
  const std::string file = writeFile("mirror.obj", "v 1 2 3\nv 2 4 3\nl 1 2\n");
  const MeshModel mesh = loadMesh(file, params);
  EXPECT_LT((mesh.lowest - Eigen::Vector3f(1, -4, 3)).norm(), 1e-6f);
  EXPECT_LT((mesh.highest - Eigen::Vector3f(2, -2, 3)).norm(), 1e-6f);
}

/// The model is in millimetres and moved. What is added is in metres, where the model lies then.
TEST(MeshLoader, AdditionsLieWhereTheModelLiesAfterItsTransform) {
  MapParameters params;
  params.scale = 0.001;
  params.x = 5;
  params.additions = writeFile("added.obj",
                               "o thing_1_lines\nv 5 0 1\nv 6 0 1\nl 1 2\n"
                               "o thing_1_hiding_faces\nv 5 1 0\nv 6 1 0\nv 5 1 1\nf 3 4 5\n") +
                     ", " + writeFile("more.obj", "o markings\nv 5 0 2\nv 7 0 2\nl 1 2\n");
  const std::string file =
      writeFile("wall.obj", "o wall\nv 0 0 0\nv 1000 0 0\nv 0 0 1000\nf 1 2 3\n");
  const MeshModel mesh = loadMesh(file, params);
  EXPECT_EQ(mesh.triangles.size(), 2u);
  EXPECT_EQ(mesh.hides_only, (std::vector<bool>{false, true}));
  EXPECT_EQ(mesh.lines.size(), 2u);
  EXPECT_LT((mesh.lowest - Eigen::Vector3f(5, 0, 0)).norm(), 1e-5f);
  EXPECT_LT((mesh.highest - Eigen::Vector3f(7, 1, 2)).norm(), 1e-5f);
  EXPECT_EQ(mesh.report.objects.count("thing_1_lines"), 1u);
  EXPECT_EQ(mesh.report.objects.count("wall"), 1u);
}

TEST(MeshLoader, AdditionsAreExcludedByNameAndNeedNotBeIncluded) {
  const std::string file = writeFile(
      "rooms.obj", "o wall\nv 0 0 0\nv 1 0 0\nv 0 0 1\nf 1 2 3\no sofa\nv 0 1 0\nv 1 1 0\nl 4 5\n");
  MapParameters params;
  params.additions = writeFile("things.obj",
                               "o thing_1\nv 0 2 1\nv 1 2 1\nl 1 2\n"
                               "o thing_2\nv 0 3 1\nv 1 3 1\nl 3 4\n");
  params.include = "wall";
  EXPECT_EQ(loadMesh(file, params).lines.size(), 2u);
  params.exclude = "thing_2";
  EXPECT_EQ(loadMesh(file, params).lines.size(), 1u);
  params.exclude = "thing_3";
  EXPECT_NE(errorOf(file, params).find("'thing_3'"), std::string::npos);
  params.additions = "/does/not/exist.obj";
  EXPECT_NE(errorOf(file, params).find(params.additions), std::string::npos);
}

TEST(MeshLoader, AnAdditionThatDoesNotBelongToTheModelIsNamed) {
  const std::string file = writeFile("hut.obj", "v 0 0 0\nv 4 0 0\nv 0 0 3\nf 1 2 3\n");
  MapParameters params;
  params.additions = writeFile("millimetres.obj", "v 0 0 0\nv 2600 0 0\nl 1 2\n");
  EXPECT_NE(errorOf(file, params).find("millimetres.obj"), std::string::npos);
  params.additions = writeFile("nan.obj", "v 0 0 0\nv nan 0 0\nl 1 2\n");
  EXPECT_NE(errorOf(file, params).find("nan.obj"), std::string::npos);
  params.additions = writeFile("yard.obj", "v 0 0 0\nv 60 0 0\nl 1 2\n");
  EXPECT_EQ(loadMesh(file, params).lines.size(), 1u);
}

/// One far line must not move the origin of a map whose poses somebody has stored.
TEST(MeshLoader, AdditionsDoNotMoveTheOrigin) {
  const std::string file =
      writeFile("far.obj", "v 500049 5400000 200\nv 500049 5400000 201\nl 1 2\n");
  MapParameters params;
  const MeshModel plain = loadMesh(file, params);
  params.additions = writeFile("far_things.obj",
                               "v 500059 5400000 200\nv 500069.1234 5400000 200\nv 500079 5400000 "
                               "200\nl 1 2\nl 2 3\n");
  const MeshModel mesh = loadMesh(file, params);
  EXPECT_EQ(mesh.origin, plain.origin);
  bool found = false;
  for (const Eigen::Vector3f& v : mesh.vertices)
    found = found || std::abs(v.x() + mesh.origin.x() - 500069.1234) < 1e-3;
  EXPECT_TRUE(found);
}

/// Loads a file of test/data.
MeshModel sample(const std::string& name) { return loadMesh(EDGE_MCL_TEST_DATA + name, {}); }

/// Vertices must have the coordinates of the file, with z up. assimp prefers y up.
TEST(MeshLoader, BuildingModelsKeepTheirAxes) {
  const MeshModel box = sample("box.ifc");  // a box of 4 x 3 m, 2.5 m high, that stands on z = 0
  EXPECT_EQ(box.triangles.size(), 12u);
  EXPECT_LT((box.lowest - Eigen::Vector3f(-2, -1.5f, 0)).norm(), 1e-5f);
  EXPECT_LT((box.highest - Eigen::Vector3f(2, 1.5f, 2.5f)).norm(), 1e-5f);
  const MeshModel triangle = sample("z_up.dae");  // vertices (0 0 0), (2 0 0), (0 1 3)
  EXPECT_LT((triangle.highest - Eigen::Vector3f(2, 1, 3)).norm(), 1e-5f);
  // Both files hold a triangle with the vertices (0 0 0), (1 0 0), (0 0 2.5).
  const std::string dxf =
      "0\nSECTION\n2\nENTITIES\n0\n3DFACE\n8\n0\n10\n0\n20\n0\n30\n0\n11\n1\n21\n0\n31\n0\n"
      "12\n0\n22\n0\n32\n2.5\n13\n0\n23\n0\n33\n2.5\n0\nENDSEC\n0\nEOF\n";
  const std::string ase =
      "*3DSMAX_ASCIIEXPORT 200\n*GEOMOBJECT {\n*NODE_NAME \"triangle\"\n*NODE_TM {\n"
      "*NODE_NAME \"triangle\"\n*TM_ROW0 1 0 0\n*TM_ROW1 0 1 0\n*TM_ROW2 0 0 1\n*TM_ROW3 0 0 0\n}\n"
      "*MESH {\n*TIMEVALUE 0\n*MESH_NUMVERTEX 3\n*MESH_NUMFACES 1\n*MESH_VERTEX_LIST {\n"
      "*MESH_VERTEX 0 0 0 0\n*MESH_VERTEX 1 1 0 0\n*MESH_VERTEX 2 0 0 2.5\n}\n*MESH_FACE_LIST {\n"
      "*MESH_FACE 0: A: 0 B: 1 C: 2 AB: 1 BC: 1 CA: 1 *MESH_SMOOTHING 1 *MESH_MTLID 0\n}\n}\n}\n";
  for (const auto& [name, text] :
       {std::pair("face.dxf", dxf), std::pair("FACE.DXF", dxf), std::pair("face.ase", ase)}) {
    const MeshModel face = loadMesh(writeFile(name, text), {});
    EXPECT_LT((face.lowest - Eigen::Vector3f(0, 0, 0)).norm(), 1e-5f) << name;
    EXPECT_LT((face.highest - Eigen::Vector3f(1, 0, 2.5f)).norm(), 1e-5f) << name;
  }
}

TEST(MeshLoader, AFileThatWasCutOffIsToldSo) {
  const std::string file = testing::TempDir() + "cut.dxf";
  const std::string face =
      "0\nSECTION\n2\nENTITIES\n0\n3DFACE\n8\n0\n10\n0\n20\n0\n30\n0\n11\n1\n21\n0\n31\n0\n"
      "12\n1\n22\n1\n32\n0\n13\n0\n23\n1\n33\n0\n0\nENDSEC\n";
  const auto isTold = [&](const std::string& text) {
    std::ofstream(file) << text;
    const std::vector<std::string> warnings = loadMesh(file, {}).report.warnings;
    return std::any_of(warnings.begin(), warnings.end(),
                       [](const std::string& w) { return w.find("cut off") != std::string::npos; });
  };
  EXPECT_TRUE(isTold(face));
  EXPECT_FALSE(isTold(face + "0\nEOF\n"));
  const std::string header =
      "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\n"
      "property float y\nproperty float z\nelement face 2\n"
      "property list uchar int vertex_indices\nend_header\n"
      "0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2\n";
  const auto isPlyTold = [&](const std::string& text) {
    const std::vector<std::string> w = loadMesh(writeFile("cut.ply", text), {}).report.warnings;
    return !w.empty() && w.front().find("cut off") != std::string::npos;
  };
  EXPECT_TRUE(isPlyTold(header));
  EXPECT_FALSE(isPlyTold(header + "3 0 2 3"));
}

}  // namespace
}  // namespace edge_mcl
