// Units and coordinates of model files.
#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "core/import/model_files.h"
#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/import/mesh_loader.h"

namespace edge_mcl {
namespace {

using test::errorOf;
using test::replaced;
using test::textOf;
using test::writeFile;

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
  std::string little = "ply\nformat binary_little_endian 1.0\n" + header;
  std::string big = "ply\nformat binary_big_endian 1.0\n" + header;
  for (const double value :
       {far.x, far.y, 112.0, far.x + 2.345, far.y, 112.0, far.x, far.y + 1.234, 115.2}) {
    std::string bytes(reinterpret_cast<const char*>(&value), sizeof(value));
    little += bytes;
    std::reverse(bytes.begin(), bytes.end());
    big += bytes;
  }
  little += std::string("\3\0\0\0\0\1\0\0\0\2\0\0\0", 13);
  big += std::string("\3\0\0\0\0\0\0\0\1\0\0\0\2", 13);
  expectTriangle(writeFile("far_binary.ply", little), far, 112);
  expectTriangle(writeFile("far_big_endian.ply", big), far, 112);
  expectTriangle(writeFile("far.dae", replaced(textOf(EDGE_MCL_TEST_DATA "z_up.dae"),
                                               "0 0 0 2 0 0 0 1 3", a + " " + b + " " + c)),
                 far, 112);
}

/// A strip of squares of 1 m along x whose coordinates are odd tenths of a millimetre.
std::string strip(const Far& far, const std::string& name, int squares, size_t first_vertex) {
  std::ostringstream text;
  text << "o " << name << "\n";
  for (int i = 0; i <= squares; ++i)
    text << "v " << far.at(i + 0.1235, 0, 5) << "\nv " << far.at(i + 0.1235, 1, 5) << "\n";
  for (int i = 0; i < squares; ++i) {
    const size_t a = first_vertex + 2 * static_cast<size_t>(i);
    text << "f " << a << " " << a + 1 << " " << a + 3 << " " << a + 2 << "\n";
  }
  return text.str();
}

/// The truth is the lowest corner of the strip that is chosen.
TEST(MeshLoader, WhatIsNotReadDoesNotPlaceTheOrigin) {
  const Far far, near{0, 0};
  const auto expectCorner = [](const std::string& file, const Far& at, const std::string& exclude) {
    MapParameters params;
    params.exclude = exclude;
    const MeshModel mesh = loadMesh(file, params);
    const Eigen::Vector3d corner = mesh.origin + mesh.lowest.cast<double>();
    EXPECT_LT((corner - Eigen::Vector3d(at.x + 0.1235, at.y, 5)).norm(), 1e-4) << file;
    EXPECT_LT(mesh.lowest.norm(), 200) << file;
    EXPECT_LT(mesh.diagonal(), 50) << file;
  };
  // A vertex of no face at the origin of the file, beside a building in its country.
  expectCorner(writeFile("stray_near.obj", "v 0 0 0\n" + strip(far, "Wall", 20, 2)), far, "");
  // The same far from a building that stands at the origin.
  expectCorner(
      writeFile("stray_far.obj", "v " + far.at(0, 0, 0) + "\n" + strip(near, "Wall", 20, 2)), near,
      "");
  expectCorner(
      writeFile("survey_near.obj", strip(near, "Survey", 2, 1) + strip(far, "Wall", 20, 7)), far,
      "Survey");
  expectCorner(writeFile("survey_far.obj", strip(far, "Survey", 2, 1) + strip(near, "Wall", 20, 7)),
               near, "Survey");
}

/// Most vertices place the shift before an importer rounds them. The others must not lose their
/// millimetres in silence.
TEST(MeshLoader, ObjectsFarFromMostOfTheFileAreRefused) {
  MapParameters params;
  params.exclude = "Terrain";
  const std::string file =
      writeFile("terrain.obj", strip(Far(), "Terrain", 50, 1) + strip({0, 0}, "Wall", 5, 103));
  EXPECT_NE(errorOf(file, params).find("another file"), std::string::npos) << errorOf(file, params);
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

/// The truth is the table of $INSUNITS in the DXF reference. A US survey foot has 1200/3937 m (NBS,
/// 1959). The model has 10 x 20 units.
TEST(MeshLoader, ADxfFileSaysItsUnit) {
  const auto load = [](int unit) {
    const std::string file = writeFile(
        "unit.dxf", "0\nSECTION\n2\nHEADER\n9\n$INSUNITS\n70\n" + std::to_string(unit) +
                        "\n0\nENDSEC\n0\nSECTION\n2\nENTITIES\n"
                        "0\n3DFACE\n8\n0\n10\n0\n20\n0\n30\n0\n11\n10\n21\n0\n31\n0\n"
                        "12\n0\n22\n0\n32\n20\n13\n0\n23\n0\n33\n20\n0\nENDSEC\n0\nEOF\n");
    return loadMesh(file, {});
  };
  for (const auto& [unit, metres] :
       {std::pair(0, 1.0), std::pair(1, 0.0254), std::pair(2, 0.3048), std::pair(3, 1609.344),
        std::pair(6, 1.0), std::pair(9, 0.0254e-3), std::pair(10, 0.9144), std::pair(14, 0.1),
        std::pair(15, 10.0), std::pair(16, 100.0), std::pair(21, 1200.0 / 3937),
        std::pair(22, 100.0 / 3937)}) {
    const MeshModel mesh = load(unit);
    const Eigen::Vector3d size = (mesh.highest - mesh.lowest).cast<double>() / metres;
    EXPECT_LT((size - Eigen::Vector3d(10, 0, 20)).norm(), 1e-4) << unit;
  }
  for (const int unit : {20, 77, -1}) {
    const std::vector<std::string> warnings = load(unit).report.warnings;
    ASSERT_FALSE(warnings.empty()) << unit;
    EXPECT_NE(warnings[0].find("not known"), std::string::npos) << warnings[0];
  }
}

/// box.ifc has 4 x 3 x 2.5 units, and assimp applies those of SI. map.scale means metres per unit
/// of the file in every format.
TEST(MeshLoader, AScaleReplacesTheUnitThatTheImporterHasApplied) {
  const std::string file = writeFile(
      "millimetres.ifc",
      replaced(textOf(EDGE_MCL_TEST_DATA "box.ifc"), ".LENGTHUNIT.,$,", ".LENGTHUNIT.,.MILLI.,"));
  MapParameters params;
  params.scale = 1;
  const MeshModel given = loadMesh(file, params);
  EXPECT_LT((given.highest - given.lowest - Eigen::Vector3f(4, 3, 2.5f)).norm(), 1e-4f);
  EXPECT_EQ(given.report.unit, "millimetre");
  params.scale = 0.001;
  const MeshModel same = loadMesh(file, params), stated = loadMesh(file, {});
  EXPECT_LT((same.highest - stated.highest).norm(), 1e-7f);
  EXPECT_EQ(stated.report.unit, "millimetre");
}

TEST(MeshLoader, UnitsThatSayNothingUsefulAreTold) {
  const std::string dae =
      replaced(textOf(EDGE_MCL_TEST_DATA "z_up.dae"), "<unit name=\"meter\" meter=\"1\"/>",
               "<unit name='inch' meter='0.0254'/>");
  const MeshModel inch = loadMesh(writeFile("inch.dae", dae), {});
  EXPECT_EQ(inch.report.unit, "inch");
  EXPECT_LT((inch.highest - 0.0254f * Eigen::Vector3f(2, 1, 3)).norm(), 1e-6f);
  const std::string foot = replaced(
      textOf(EDGE_MCL_TEST_DATA "box.ifc"), "#11=IFCSIUNIT(*,.LENGTHUNIT.,$,.METRE.);",
      "#11=IFCCONVERSIONBASEDUNIT(#33,.LENGTHUNIT.,'FOOT',#32);\n"
      "#30=IFCSIUNIT(*,.LENGTHUNIT.,$,.METRE.);\n#32=IFCMEASUREWITHUNIT(IFCLENGTHMEASURE(0.),#30);"
      "\n#33=IFCDIMENSIONALEXPONENTS(1,0,0,0,0,0,0);");
  const std::vector<std::string> warnings =
      loadMesh(writeFile("zero.ifc", foot), {}).report.warnings;
  ASSERT_FALSE(warnings.empty());
  EXPECT_NE(warnings[0].find("FOOT"), std::string::npos) << warnings[0];
}

}  // namespace
}  // namespace edge_mcl
