#include <gtest/gtest.h>

#include <fstream>
#include <sstream>
#include <string>
#include <utility>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/mesh/mesh_model.h"

namespace edge_mcl {
namespace {

std::string writeFile(const std::string& name, const std::string& text) {
  std::string file = testing::TempDir() + name;
  std::ofstream(file) << text;
  return file;
}

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

/// Vertices have single precision. National map coordinates of this precision are rounded to
/// decimetres, so a robot cannot be localized in such a model.
TEST(MeshLoader, AModelFarFromItsOriginIsRefusedOrWarnedOf) {
  const auto at = [](double x) {
    std::ostringstream text;
    text.precision(12);
    text << "v " << x << " 0 0\nv " << x + 50 << " 0 0\nv " << x << " 50 0\nf 1 2 3\n";
    return writeFile("far.obj", text.str());
  };
  EXPECT_TRUE(loadMesh(at(1000), {}).report.warnings.empty());
  EXPECT_EQ(loadMesh(at(20000), {}).report.warnings.size(), 1u);
  EXPECT_THROW(loadMesh(at(600000), {}), InputError);
  MapParameters moved;
  moved.x = -600000;  // the vertices are rounded before this offset is added
  EXPECT_THROW(loadMesh(at(600000), moved), InputError);
  MapParameters millimetres;
  millimetres.scale = 0.001;
  EXPECT_TRUE(loadMesh(at(600000), millimetres).report.warnings.empty());
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

}  // namespace
}  // namespace edge_mcl
