#include "edge_mcl/core/import/cad_reader.h"

#include <BRepAdaptor_Curve.hxx>
#include <BRepMesh_IncrementalMesh.hxx>
#include <BRepTools.hxx>
#include <BRep_Builder.hxx>
#include <BRep_Tool.hxx>
#include <GCPnts_TangentialDeflection.hxx>
#include <IGESCAFControl_Reader.hxx>
#include <IGESData_IGESModel.hxx>
#include <Poly_Triangulation.hxx>
#include <Quantity_Color.hxx>
#include <STEPCAFControl_Reader.hxx>
#include <Standard_Failure.hxx>
#include <Standard_OutOfMemory.hxx>
#include <TDF_LabelSequence.hxx>
#include <TDataStd_Name.hxx>
#include <TDocStd_Document.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <XCAFDoc_ColorTool.hxx>
#include <XCAFDoc_DocumentTool.hxx>
#include <XCAFDoc_ShapeTool.hxx>
#include <algorithm>
#include <array>
#include <cctype>
#include <map>
#include <new>
#include <string_view>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/import/file_facts.h"

namespace edge_mcl {

namespace {

constexpr double kMetre = 0.001;        // OpenCASCADE delivers millimetres
constexpr double kDeflection = 2;       // mm, less than what an edge in an image is good to
constexpr double kTurn = 0.3;           // rad between facets; smaller than edges.crease_angle_deg
constexpr double kSmallestPart = 0.01;  // mm

/// Name of a label of the document, empty if it has none.
std::string nameOf(const TDF_Label& label) {
  Handle(TDataStd_Name) name;
  if (!label.FindAttribute(TDataStd_Name::GetID(), name)) return {};
  const TCollection_ExtendedString& text = name->Get();
  std::string bytes(static_cast<size_t>(text.LengthOfCString()) + 1, '\0');
  Standard_PCharacter begin = bytes.data();
  bytes.resize(static_cast<size_t>(std::max(0, text.ToUTF8CString(begin))));
  return bytes;
}

/// Adds the parts of a document, or a single shape, to a model.
class CadParts {
 public:
  explicit CadParts(RawModel* model) : model_(model) {
    model_->material_colors.emplace_back(0.7f, 0.7f, 0.7f);
  }

  void addDocument(const Handle(TDocStd_Document) & document) {
    shapes_ = XCAFDoc_DocumentTool::ShapeTool(document->Main());
    colors_ = XCAFDoc_DocumentTool::ColorTool(document->Main());
    TDF_LabelSequence roots;
    shapes_->GetFreeShapes(roots);
    for (Standard_Integer i = 1; i <= roots.Length(); ++i)
      addLabel(roots.Value(i), TopLoc_Location(), "", 0);
  }

  void addShape(const TopoDS_Shape& shape, const std::string& name, uint32_t material) {
    if (shape.IsNull()) return;
    BRepMesh_IncrementalMesh mesher(shape, kDeflection, Standard_False, kTurn);
    const auto [it, is_new] = numbers_.emplace(name, static_cast<uint32_t>(model_->objects.size()));
    if (is_new) model_->objects.push_back(name);
    for (TopExp_Explorer face(shape, TopAbs_FACE); face.More(); face.Next())
      addFace(TopoDS::Face(face.Current()), it->second, material);
    for (TopExp_Explorer edge(shape, TopAbs_EDGE, TopAbs_FACE); edge.More(); edge.Next())
      addCurve(TopoDS::Edge(edge.Current()), it->second);
  }

 private:
  /// @param parent place of the assembly that holds the label.
  /// @param name of the nearest assembly that has one.
  void addLabel(const TDF_Label& label, const TopLoc_Location& parent, const std::string& name,
                int depth) {
    constexpr int kDeepest = 200;  // assemblies in assemblies; a deeper tree is a loop
    if (depth > kDeepest) throw InputError("the tree of parts is too deep");
    TDF_Label part = label;
    TopLoc_Location place = parent;
    if (XCAFDoc_ShapeTool::IsReference(label)) {
      place = parent * XCAFDoc_ShapeTool::GetLocation(label);
      XCAFDoc_ShapeTool::GetReferredShape(label, part);
    }
    const std::string own = nameOf(part);
    const std::string& known = own.empty() ? name : own;
    if (XCAFDoc_ShapeTool::IsAssembly(part)) {
      TDF_LabelSequence components;
      XCAFDoc_ShapeTool::GetComponents(part, components);
      for (Standard_Integer i = 1; i <= components.Length(); ++i)
        addLabel(components.Value(i), place, known, depth + 1);
      return;
    }
    const TopoDS_Shape shape = XCAFDoc_ShapeTool::GetShape(part);
    if (!shape.IsNull())
      addShape(shape.Moved(place), known.empty() ? "unnamed" : known, material(label, part));
  }

  /// Number of the colour of an instance, else of its part.
  uint32_t material(const TDF_Label& instance, const TDF_Label& part) {
    Quantity_Color color;
    for (const TDF_Label& label : {instance, part})
      for (const XCAFDoc_ColorType type : {XCAFDoc_ColorSurf, XCAFDoc_ColorGen})
        if (colors_->GetColor(label, type, color)) {
          const Eigen::Vector3f rgb(static_cast<float>(color.Red()),
                                    static_cast<float>(color.Green()),
                                    static_cast<float>(color.Blue()));
          std::vector<Eigen::Vector3f>& known = model_->material_colors;
          const auto it = std::find(known.begin(), known.end(), rgb);
          const auto number = static_cast<uint32_t>(it - known.begin());
          if (it == known.end()) known.push_back(rgb);
          return number;
        }
    return 0;
  }

  uint32_t addVertex(const gp_Pnt& p) {
    model_->vertices.emplace_back(kMetre * p.X(), kMetre * p.Y(), kMetre * p.Z());
    model_->rounding.push_back(0);  // OpenCASCADE keeps double precision
    return static_cast<uint32_t>(model_->vertices.size() - 1);
  }

  void addFace(const TopoDS_Face& face, uint32_t object, uint32_t material) {
    TopLoc_Location place;
    const Handle(Poly_Triangulation) mesh = BRep_Tool::Triangulation(face, place);
    if (mesh.IsNull()) {
      ++model_->empty_faces;
      return;
    }
    const gp_Trsf to_map = place.Transformation();
    const auto offset = static_cast<uint32_t>(model_->vertices.size());
    for (Standard_Integer i = 1; i <= mesh->NbNodes(); ++i)
      addVertex(mesh->Node(i).Transformed(to_map));
    const bool is_turned = face.Orientation() == TopAbs_REVERSED;
    for (Standard_Integer i = 1; i <= mesh->NbTriangles(); ++i) {
      Standard_Integer a = 0, b = 0, c = 0;
      mesh->Triangle(i).Get(a, b, c);
      if (is_turned) std::swap(b, c);
      model_->triangles.push_back({offset + static_cast<uint32_t>(a) - 1,
                                   offset + static_cast<uint32_t>(b) - 1,
                                   offset + static_cast<uint32_t>(c) - 1});
      model_->triangle_material.push_back(material);
      model_->triangle_object.push_back(object);
    }
  }

  void addCurve(const TopoDS_Edge& edge, uint32_t object) {
    if (BRep_Tool::Degenerated(edge)) return;
    const BRepAdaptor_Curve curve(edge);
    const GCPnts_TangentialDeflection points(curve, kTurn, kDeflection, 2, 1e-9, kSmallestPart);
    for (Standard_Integer i = 1; i <= points.NbPoints(); ++i) {
      const uint32_t vertex = addVertex(points.Value(i));
      if (i == 1) continue;
      model_->lines.push_back({vertex - 1, vertex});
      model_->line_object.push_back(object);
    }
  }

  RawModel* model_;
  Handle(XCAFDoc_ShapeTool) shapes_;
  Handle(XCAFDoc_ColorTool) colors_;
  std::map<std::string, uint32_t> numbers_;
};

/// Notes the unit of the file in its own words, which are in capitals, e.g. MILLIMETRE.
void noteUnit(std::string name, RawModel* model) {
  struct Unit {
    std::string_view name;
    double metres;
  };
  constexpr std::array<Unit, 14> kUnits{{{"millimetre", 1e-3},
                                         {"mm", 1e-3},
                                         {"centimetre", 1e-2},
                                         {"cm", 1e-2},
                                         {"decimetre", 0.1},
                                         {"metre", 1},
                                         {"m", 1},
                                         {"kilometre", 1000},
                                         {"km", 1000},
                                         {"inch", 0.0254},
                                         {"in", 0.0254},
                                         {"foot", 0.3048},
                                         {"ft", 0.3048},
                                         {"mile", 1609.344}}};
  std::transform(name.begin(), name.end(), name.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  const auto* const unit = std::find_if(kUnits.begin(), kUnits.end(),
                                        [&](const Unit& known) { return known.name == name; });
  if (unit == kUnits.end()) return;
  model->unit = unit->metres;
  if (unit->metres != 1) model->unit_name = name;
}

[[noreturn]] void fail(const std::string& file, const std::string& reason) {
  throw InputError(file + ": not readable as a 3D model: " + reason);
}

void readStep(const std::string& file, Handle(TDocStd_Document) document, RawModel* model) {
  STEPCAFControl_Reader reader;
  if (reader.ReadFile(file.c_str()) != IFSelect_RetDone) fail(file, "it is no whole STEP file");
  TColStd_SequenceOfAsciiString lengths, angles, solid_angles;
  reader.ChangeReader().FileUnits(lengths, angles, solid_angles);
  const bool is_one = lengths.Length() > 0 && std::all_of(lengths.begin(), lengths.end(),
                                                          [&](const TCollection_AsciiString& u) {
                                                            return u == lengths.First();
                                                          });
  if (is_one) noteUnit(lengths.First().ToCString(), model);
  if (!reader.Transfer(document)) fail(file, "OpenCASCADE finds no shape in it");
}

void readIges(const std::string& file, Handle(TDocStd_Document) document, RawModel* model) {
  IGESCAFControl_Reader reader;
  if (reader.ReadFile(file.c_str()) != IFSelect_RetDone) fail(file, "it is no whole IGES file");
  // The flag decides the scale, whatever the name beside it says.
  const std::map<int, const char*> units{{1, "inch"},       {2, "millimetre"}, {4, "foot"},
                                         {5, "mile"},       {6, "metre"},      {7, "kilometre"},
                                         {10, "centimetre"}};
  const auto unit = units.find(reader.IGESModel()->GlobalSection().UnitFlag());
  if (unit != units.end()) noteUnit(unit->second, model);
  if (!reader.Transfer(document)) fail(file, "OpenCASCADE finds no shape in it");
}

RawModel readWithOcct(const std::string& file) {
  RawModel model;
  model.in_metres = true;
  CadParts parts(&model);
  const std::string extension = extensionOf(file);
  if (extension == ".brep" || extension == ".brp") {
    TopoDS_Shape shape;
    const BRep_Builder builder;
    if (!BRepTools::Read(shape, file.c_str(), builder)) fail(file, "it is no whole BREP file");
    noteUnit("millimetre", &model);
    parts.addShape(shape, "unnamed", 0);
    return model;
  }
  Handle(TDocStd_Document) document = new TDocStd_Document("BinXCAF");
  if (extension == ".igs" || extension == ".iges")
    readIges(file, document, &model);
  else
    readStep(file, document, &model);
  parts.addDocument(document);
  return model;
}

}  // namespace

RawModel readCadFile(const std::string& file) {
  try {
    return readWithOcct(file);
  } catch (const Standard_OutOfMemory&) {
    throw std::bad_alloc();
  } catch (const Standard_Failure& failure) {
    const std::string reason = failure.GetMessageString() ? failure.GetMessageString() : "";
    fail(file, reason.empty() ? "OpenCASCADE gives no reason" : reason);
  }
}

}  // namespace edge_mcl
