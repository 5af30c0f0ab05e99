// Files of CAD programs, written by OpenCASCADE's own writers, against the shapes' closed forms.
#include <gtest/gtest.h>

#include <BRepAlgoAPI_Cut.hxx>
#include <BRepBuilderAPI_MakeEdge.hxx>
#include <BRepPrimAPI_MakeBox.hxx>
#include <BRepPrimAPI_MakeCylinder.hxx>
#include <BRepTools.hxx>
#include <IGESControl_Writer.hxx>
#include <Interface_Static.hxx>
#include <Quantity_Color.hxx>
#include <STEPCAFControl_Writer.hxx>
#include <STEPControl_Writer.hxx>
#include <StepData_StepModel.hxx>
#include <TDataStd_Name.hxx>
#include <TDocStd_Document.hxx>
#include <XCAFDoc_ColorTool.hxx>
#include <XCAFDoc_DocumentTool.hxx>
#include <XCAFDoc_ShapeTool.hxx>
#include <algorithm>
#include <cmath>
#include <map>
#include <string>

#include "core/import/model_files.h"
#include "edge_mcl/core/edges/edge_model.h"

namespace edge_mcl {
namespace {

using test::errorOf;

std::string pathOf(const std::string& name) { return testing::TempDir() + name; }

/// A room of 4 x 3 x 2.5 m inside a block with walls of 0.2 m. Lengths of OpenCASCADE are in mm.
TopoDS_Shape room(const gp_Pnt& corner = gp_Pnt(0, 0, 0)) {
  const TopoDS_Shape block = BRepPrimAPI_MakeBox(corner, 4400, 3400, 2900).Shape();
  const gp_Pnt inside(corner.X() + 200, corner.Y() + 200, corner.Z() + 200);
  return BRepAlgoAPI_Cut(block, BRepPrimAPI_MakeBox(inside, 4000, 3000, 2500).Shape()).Shape();
}

/// @param unit as OpenCASCADE calls it. @return the file.
std::string writeStep(const TopoDS_Shape& shape, const std::string& name, const char* unit) {
  const STEPControl_Writer first;  // the parameter exists from here on
  Interface_Static::SetCVal("write.step.unit", unit);
  STEPControl_Writer writer;  // it reads the parameter now
  // OpenCASCADE 7.8 uses the parameter for the header alone. The coordinates need the model's unit.
  static const std::map<std::string, double> millimetres{
      {"MM", 1}, {"INCH", 25.4}, {"FT", 304.8}, {"CM", 10}, {"M", 1000}};
  writer.Model()->SetWriteLengthUnit(millimetres.at(unit));
  EXPECT_EQ(writer.Transfer(shape, STEPControl_AsIs), IFSelect_RetDone);
  EXPECT_EQ(writer.Write(pathOf(name).c_str()), IFSelect_RetDone);
  Interface_Static::SetCVal("write.step.unit", "MM");
  return pathOf(name);
}

/// Volume that the triangles enclose, by the divergence theorem. m3
double volumeOf(const MeshModel& mesh) {
  double volume = 0;
  for (const auto& t : mesh.triangles) {
    const Eigen::Vector3d a = mesh.vertices[t[0]].cast<double>(),
                          b = mesh.vertices[t[1]].cast<double>(),
                          c = mesh.vertices[t[2]].cast<double>();
    volume += a.dot(b.cross(c)) / 6;
  }
  return volume;
}

void expectRoom(const MeshModel& mesh) {
  EXPECT_TRUE(mesh.lowest.isApprox(Eigen::Vector3f::Zero(), 1e-5f));
  EXPECT_TRUE(mesh.highest.isApprox(Eigen::Vector3f(4.4f, 3.4f, 2.9f), 1e-5f));
  EXPECT_EQ(mesh.triangles.size(), 24u);  // two for each of twelve faces
  EXPECT_NEAR(volumeOf(mesh), 4.4 * 3.4 * 2.9 - 4 * 3 * 2.5, 1e-4);
  EXPECT_EQ(mesh.vertices.size(), 16u);  // faces are joined
}

TEST(CadReader, StepIsInMetresWhateverItsUnit) {
  struct Unit {
    const char *occt, *told;
  };
  for (const Unit& unit : {Unit{"MM", "millimetre"}, Unit{"INCH", "inch"}, Unit{"FT", "foot"},
                           Unit{"CM", "centimetre"}, Unit{"M", ""}}) {
    SCOPED_TRACE(unit.occt);
    const MeshModel mesh = loadMesh(writeStep(room(), "room.step", unit.occt), {});
    expectRoom(mesh);
    EXPECT_EQ(mesh.report.unit, unit.told);
  }
}

TEST(CadReader, ScaleReplacesTheUnitOfTheFile) {
  MapParameters params;
  params.scale = 0.002;  // m for each unit of the file, which says 0.001
  const MeshModel mesh = loadMesh(writeStep(room(), "scaled.stp", "MM"), params);
  EXPECT_NEAR(mesh.highest.x(), 8.8f, 1e-4f);
}

TEST(CadReader, IgesAndBrep) {
  IGESControl_Writer writer("MM", 1);
  ASSERT_TRUE(writer.AddShape(room()));
  writer.ComputeModel();
  ASSERT_TRUE(writer.Write(pathOf("room.igs").c_str()));
  expectRoom(loadMesh(pathOf("room.igs"), {}));
  ASSERT_TRUE(BRepTools::Write(room(), pathOf("room.brep").c_str()));
  expectRoom(loadMesh(pathOf("room.brep"), {}));
}

TEST(CadReader, AColumnIsOffByTwoMillimetresAndHasNoFalseEdges) {
  const TopoDS_Shape column = BRepPrimAPI_MakeCylinder(300, 2500).Shape();
  const MeshModel mesh = loadMesh(writeStep(column, "column.step", "MM"), {});
  for (const auto& t : mesh.triangles)
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3f middle = (mesh.vertices[t[k]] + mesh.vertices[t[(k + 1) % 3]]) / 2;
      const bool is_cap = std::abs(mesh.vertices[t[0]].z() - mesh.vertices[t[1]].z()) +
                              std::abs(mesh.vertices[t[0]].z() - mesh.vertices[t[2]].z()) <
                          1e-4f;
      if (!is_cap) {
        EXPECT_NEAR(middle.head<2>().norm(), 0.3f, 0.002f);
      }
    }
  MeshModel for_edges = mesh;
  const EdgeModel model = buildEdgeModel(&for_edges, {});
  double creases = 0;
  for (const EdgeLine& line : model.lines)
    if (line.kind == EdgeKind::kCrease) creases += static_cast<double>(line.length());
  EXPECT_NEAR(creases, 2 * 2 * M_PI * 0.3, 0.05);  // the two rims; none along the column
}

TEST(CadReader, PartsOfAnAssemblyHavePlacesNamesAndColours) {
  Handle(TDocStd_Document) document = new TDocStd_Document("BinXCAF");
  const auto shapes = XCAFDoc_DocumentTool::ShapeTool(document->Main());
  const auto colors = XCAFDoc_DocumentTool::ColorTool(document->Main());
  const TDF_Label table = shapes->AddShape(BRepPrimAPI_MakeBox(800, 800, 700).Shape(), false);
  TDataStd_Name::Set(table, "Table");
  colors->SetColor(table, Quantity_Color(1, 0, 0, Quantity_TOC_RGB), XCAFDoc_ColorSurf);
  const TDF_Label floor = shapes->NewShape();
  TDataStd_Name::Set(floor, "Floor");
  gp_Trsf turned;  // a quarter to the left about the upward axis, then 5 m along x
  turned.SetRotation(gp_Ax1(gp_Pnt(0, 0, 0), gp_Dir(0, 0, 1)), M_PI / 2);
  turned.SetTranslationPart(gp_Vec(5000, 0, 0));
  shapes->AddComponent(floor, table, TopLoc_Location());
  shapes->AddComponent(floor, table, TopLoc_Location(turned));
  shapes->UpdateAssemblies();
  STEPCAFControl_Writer writer;
  ASSERT_TRUE(writer.Transfer(document));
  ASSERT_EQ(writer.Write(pathOf("floor.step").c_str()), IFSelect_RetDone);

  const MeshModel mesh = loadMesh(pathOf("floor.step"), {});
  EXPECT_EQ(mesh.triangles.size(), 24u);
  EXPECT_TRUE(mesh.lowest.isApprox(Eigen::Vector3f(0, 0, 0), 1e-5f)) << mesh.lowest.transpose();
  EXPECT_NEAR(mesh.highest.x(), 5.0f, 1e-5f);  // the second one reaches from 4.2 to 5 m
  ASSERT_EQ(mesh.report.objects.size(), 1u);
  EXPECT_EQ(mesh.report.objects.begin()->first, "Table");
  const Eigen::Vector3f color = mesh.material_colors[mesh.triangle_material.front()];
  EXPECT_NEAR(color.x(), 1, 1e-3f);
  EXPECT_NEAR(color.y(), 0, 1e-3f);
}

TEST(CadReader, CoordinatesOfACountryKeepTheirMillimetres) {
  const gp_Pnt far(500000e3 + 0.4, 5400000e3 + 0.7, 200e3);
  const MeshModel mesh = loadMesh(writeStep(room(far), "far.step", "MM"), {});
  const Eigen::Vector3d corner = mesh.origin + mesh.lowest.cast<double>();
  EXPECT_LT((corner - Eigen::Vector3d(500000.0004, 5400000.0007, 200)).norm(), 1e-4);
  EXPECT_EQ(mesh.triangles.size(), 24u);
}

TEST(CadReader, ACurveWithoutAFaceIsALine) {
  const TopoDS_Shape edge = BRepBuilderAPI_MakeEdge(gp_Pnt(0, 0, 0), gp_Pnt(2000, 0, 0)).Shape();
  const MeshModel mesh = loadMesh(writeStep(edge, "edge.step", "MM"), {});
  ASSERT_EQ(mesh.lines.size(), 1u);
  EXPECT_NEAR(mesh.highest.x(), 2, 1e-6f);
}

TEST(CadReader, BrokenFilesAreOneLine) {
  const std::string whole = test::textOf(writeStep(room(), "whole.step", "MM"));
  const auto errorFor = [](const std::string& name, const std::string& text) {
    return errorOf(test::writeFile(name, text));
  };
  EXPECT_NE(errorFor("empty.step", "").find("empty.step"), std::string::npos);
  EXPECT_NE(errorFor("words.step", "this is no model").find("not readable"), std::string::npos);
  EXPECT_NE(errorFor("words.igs", "this is no model").find("not readable"), std::string::npos);
  EXPECT_NE(errorFor("words.brep", "this is no model").find("not readable"), std::string::npos);
  // A file that was cut off is refused, or its loss is told.
  const std::string cut = test::writeFile("cut.step", whole.substr(0, whole.size() / 2));
  if (errorOf(cut) == "no error") {
    const std::vector<std::string> warnings = loadMesh(cut, {}).report.warnings;
    EXPECT_TRUE(std::any_of(warnings.begin(), warnings.end(), [](const std::string& warning) {
      return warning.find("ends too early") != std::string::npos;
    }));
  }
}

}  // namespace
}  // namespace edge_mcl
