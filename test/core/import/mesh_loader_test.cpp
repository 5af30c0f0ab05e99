#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <tuple>
#include <utility>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/import/mesh_loader.h"
#include "edge_mcl/core/mesh/mesh_model.h"

namespace edge_mcl {
namespace {

std::string writeFile(const std::string& name, const std::string& text) {
  std::string file = testing::TempDir() + name;
  std::ofstream(file) << text;
  return file;
}

std::string textOf(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// The text with `what`, which must occur in it, replaced by `by`.
std::string replaced(std::string text, const std::string& what, const std::string& by) {
  const size_t at = text.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  return at == std::string::npos ? text : text.replace(at, what.size(), by);
}

/// The text of the error that loading a file gives.
std::string errorOf(const std::string& file, const MapParameters& params = {}) {
  try {
    loadMesh(file, params);
  } catch (const InputError& e) {
    return e.what();
  }
  return "no error";
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

/// Moves x and y of a model to national coordinates.
struct Far {
  double x = 458123.4, y = 5428765.4;
  std::string at(double px, double py, double pz) const {
    std::ostringstream text;
    text.precision(12);
    text << px + x << " " << py + y << " " << pz;
    return text.str();
  }
};

/// A triangle with the corners (0 0 0), (2.345 0 0), (0 1.234 3.2). The truth is its shape and the
/// place of its corner at the right angle in the file.
void expectTriangle(const std::string& file, const Far& far, double z) {
  const MeshModel mesh = loadMesh(file, {});
  ASSERT_EQ(mesh.triangles.size(), 1u) << file;
  const auto vertex = [&](int i) -> Eigen::Vector3d {
    return mesh.origin + mesh.vertices[mesh.triangles[0][i]].cast<double>();
  };
  // Single precision is good to 0.01 mm within 100 m of the origin of the map frame.
  EXPECT_LT((vertex(0) - Eigen::Vector3d(far.x, far.y, z)).norm(), 1e-4) << file;
  EXPECT_LT((vertex(1) - Eigen::Vector3d(far.x + 2.345, far.y, z)).norm(), 1e-4) << file;
  EXPECT_LT((vertex(2) - Eigen::Vector3d(far.x, far.y + 1.234, z + 3.2)).norm(), 1e-4) << file;
  EXPECT_LT(mesh.lowest.norm(), 200) << file;
}

TEST(MeshLoader, CoordinatesOfACountryKeepTheirMillimetres) {
  const Far far;
  const std::string a = far.at(0, 0, 112), b = far.at(2.345, 0, 112), c = far.at(0, 1.234, 115.2);
  expectTriangle(writeFile("far.obj", "v " + a + "\nv " + b + "\nv " + c + "\nf 1 2 3\n"), far,
                 112);
  expectTriangle(
      writeFile("far.stl", "solid s\nfacet normal 0 0 1\nouter loop\nvertex " + a + "\nvertex " +
                               b + "\nvertex " + c + "\nendloop\nendfacet\nendsolid s\n"),
      far, 112);
  const std::string header =
      "element vertex 3\nproperty double x\nproperty double y\nproperty double z\n"
      "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
  expectTriangle(writeFile("far.ply", "ply\nformat ascii 1.0\n" + header + a + "\n" + b + "\n" + c +
                                          "\n3 0 1 2\n"),
                 far, 112);
  std::string binary = "ply\nformat binary_little_endian 1.0\n" + header;
  for (const double value :
       {far.x, far.y, 112.0, far.x + 2.345, far.y, 112.0, far.x, far.y + 1.234, 115.2})
    binary.append(reinterpret_cast<const char*>(&value), sizeof(value));
  binary += std::string("\3\0\0\0\0\1\0\0\0\2\0\0\0", 13);
  expectTriangle(writeFile("far_binary.ply", binary), far, 112);
  expectTriangle(writeFile("far.dae", replaced(textOf(EDGE_MCL_TEST_DATA "z_up.dae"),
                                               "0 0 0 2 0 0 0 1 3", a + " " + b + " " + c)),
                 far, 112);
}

/// The truth is the box of box.ifc, which has 4 x 3 x 2.5 m, at the place of its building.
TEST(MeshLoader, AnIfcFileMayStandInItsCountry) {
  const std::string text = textOf(EDGE_MCL_TEST_DATA "box.ifc");
  const std::string file = writeFile(
      "far.ifc", replaced(replaced(text, "#15=IFCLOCALPLACEMENT($,#9);",
                                   "#15=IFCLOCALPLACEMENT($,#30);\n"
                                   "#29=IFCCARTESIANPOINT((458123400.,5428765400.,112000.));\n"
                                   "#30=IFCAXIS2PLACEMENT3D(#29,#7,#8);"),
                          ".LENGTHUNIT.,$,", ".LENGTHUNIT.,.MILLI.,"));
  MapParameters given;
  given.origin = "458123.4,5428765.4,112";
  const MeshModel box = loadMesh(file, given);
  // The box has 4 x 3 x 2.5 mm in this file, of which a thousandth is the tolerance.
  EXPECT_LT((box.lowest - Eigen::Vector3f(-0.002f, -0.0015f, 0)).norm(), 1e-5f);
  EXPECT_LT((box.highest - Eigen::Vector3f(0.002f, 0.0015f, 0.0025f)).norm(), 1e-5f);
}

/// Coordinates of a binary STL file have single precision, which no reader can mend.
TEST(MeshLoader, AModelThatIsRoundedInItsFileIsRefusedOrWarnedOf) {
  const auto at = [](float x) {
    std::string text(80, ' ');
    text += std::string("\1\0\0\0", 4);
    for (const float value : {0.f, 0.f, 1.f, x, 0.f, 0.f, x + 50, 0.f, 0.f, x, 50.f, 0.f})
      text.append(reinterpret_cast<const char*>(&value), sizeof(value));
    return writeFile("far_binary.stl", text + std::string(2, '\0'));
  };
  EXPECT_TRUE(loadMesh(at(1000), {}).report.warnings.empty());
  EXPECT_EQ(loadMesh(at(20000), {}).report.warnings.size(), 2u);  // and the origin
  EXPECT_THROW(loadMesh(at(600000), {}), InputError);
  MapParameters millimetres;
  millimetres.scale = 0.001;
  EXPECT_TRUE(loadMesh(at(600000), millimetres).report.warnings.empty());
}

TEST(MeshLoader, TheOriginMayBeGiven) {
  MapParameters params;
  params.origin = "10,20,30";
  const std::string file = writeFile("given.obj", "v 10 20 30\nv 11 20 30\nv 10 21 30\nf 1 2 3\n");
  const MeshModel mesh = loadMesh(file, params);
  EXPECT_LT(mesh.lowest.norm(), 1e-6f);
  EXPECT_LT((mesh.origin - Eigen::Vector3d(10, 20, 30)).norm(), 1e-12);
  for (const char* wrong : {"", "1,2", "1,2,3,4", "1;2;3", "nan,0,0", "here"}) {
    params.origin = wrong;
    EXPECT_EQ(params.faults().size(), 1u) << wrong;
  }
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

/// The box of box.ifc has 4 x 3 x 2.5 units. The truth is the length of a foot and of an inch in
/// metres (ISO 31-1).
TEST(MeshLoader, AnIfcFileInFeetOrInchesIsReadInMetres) {
  const std::string text = textOf(EDGE_MCL_TEST_DATA "box.ifc");
  for (const auto& [name, measure, metres] :
       {std::tuple("FOOT", "0.3048),#30", 0.3048), std::tuple("INCH", "2.54),#31", 0.0254)}) {
    const std::string unit = "#11=IFCCONVERSIONBASEDUNIT(#33,.LENGTHUNIT.,'" + std::string(name) +
                             "',#32);\n#30=IFCSIUNIT(*,.LENGTHUNIT.,$,.METRE.);\n"
                             "#31=IFCSIUNIT(*,.LENGTHUNIT.,.CENTI.,.METRE.);\n"
                             "#32=IFCMEASUREWITHUNIT(IFCLENGTHMEASURE(" +
                             measure + ");\n#33=IFCDIMENSIONALEXPONENTS(1,0,0,0,0,0,0);";
    const std::string file =
        writeFile(std::string(name) + ".ifc",
                  replaced(text, "#11=IFCSIUNIT(*,.LENGTHUNIT.,$,.METRE.);", unit));
    const MeshModel box = loadMesh(file, {});
    const Eigen::Vector3d size = (box.highest - box.lowest).cast<double>();
    EXPECT_LT((size - metres * Eigen::Vector3d(4, 3, 2.5)).norm(), 1e-5) << name;
    EXPECT_EQ(box.report.unit, name);
    MapParameters given;
    given.scale = 1;
    EXPECT_NEAR(loadMesh(file, given).highest.z(), 2.5, 1e-5) << name;
  }
}

TEST(MeshLoader, ADxfFileSaysItsUnit) {
  const std::string file =
      writeFile("inch.dxf",
                "0\nSECTION\n2\nHEADER\n9\n$INSUNITS\n70\n1\n0\nENDSEC\n0\nSECTION\n2\nENTITIES\n"
                "0\n3DFACE\n8\n0\n10\n0\n20\n0\n30\n0\n11\n100\n21\n0\n31\n0\n"
                "12\n0\n22\n0\n32\n200\n13\n0\n23\n0\n33\n200\n0\nENDSEC\n0\nEOF\n");
  EXPECT_LT((loadMesh(file, {}).highest - Eigen::Vector3f(2.54f, 0, 5.08f)).norm(), 1e-5f);
}

TEST(MeshLoader, WhatCannotBeReadIsNamedWithAWayOn) {
  const std::string ifc4 = writeFile(
      "new.ifc", replaced(textOf(EDGE_MCL_TEST_DATA "box.ifc"), "'IFC2X3'", "'IFC4X3_ADD2'"));
  EXPECT_NE(errorOf(ifc4).find("IFC4X3_ADD2"), std::string::npos);
  EXPECT_NE(errorOf(ifc4).find("IfcConvert"), std::string::npos);
  EXPECT_NE(errorOf(writeFile("a.STEP", "ISO-10303-21;")).find("FreeCAD"), std::string::npos);
  const std::string strips = writeFile("strips.ply",
                                       "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\n"
                                       "element tristrips 1\nproperty list int int vertex_indices\n"
                                       "end_header\n0\n3 0 0 0\n");
  EXPECT_NE(errorOf(strips).find("triangle strips"), std::string::npos);
}

/// assimp 5.2 reads a null pointer when an IFC2X3 file holds this entity of IFC4.
TEST(MeshLoader, AnImporterThatCrashesIsOneError) {
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

TEST(MeshLoader, AMirroredAxisIsTurnedBack) {
  MapParameters params;
  params.mirror = "y";
  const std::string file = writeFile("mirror.obj", "v 1 2 3\nv 2 4 3\nl 1 2\n");
  const MeshModel mesh = loadMesh(file, params);
  EXPECT_LT((mesh.lowest - Eigen::Vector3f(1, -4, 3)).norm(), 1e-6f);
  EXPECT_LT((mesh.highest - Eigen::Vector3f(2, -2, 3)).norm(), 1e-6f);
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
}

}  // namespace
}  // namespace edge_mcl
