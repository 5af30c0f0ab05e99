#include "edge_mcl/core/import/scene_reader.h"

#include <assimp/config.h>
#include <assimp/material.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <assimp/Importer.hpp>
#include <cmath>
#include <map>
#include <new>
#include <optional>
#include <string_view>
#include <utility>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/import/coordinate_shift.h"
#include "edge_mcl/core/import/file_facts.h"
#include "edge_mcl/core/import/guarded_file_system.h"
#include "edge_mcl/core/import/ply_header.h"
#include "edge_mcl/core/import/polygon_ears.h"

namespace edge_mcl {

namespace {

/// Removes empty faces and checks the vertex numbers of all faces. The triangulation of assimp does
/// not check the numbers. It ends the process when a mesh has empty faces but no polygons.
/// @return number of empty faces that were removed.
/// @throws InputError when a face refers to a vertex that does not exist.
size_t prepareForTriangulation(aiScene* scene, const std::string& origin) {
  size_t empty = 0;
  for (unsigned m = 0; m < scene->mNumMeshes; ++m) {
    aiMesh& mesh = *scene->mMeshes[m];
    unsigned kept = 0, types = 0;
    for (unsigned i = 0; i < mesh.mNumFaces; ++i) {
      const aiFace& face = mesh.mFaces[i];
      for (unsigned k = 0; k < face.mNumIndices; ++k)
        if (face.mIndices[k] >= mesh.mNumVertices)
          throw InputError(origin + ": a face refers to a vertex that does not exist");
      if (face.mNumIndices == 0) continue;
      types |= face.mNumIndices == 1   ? aiPrimitiveType_POINT
               : face.mNumIndices == 2 ? aiPrimitiveType_LINE
               : face.mNumIndices == 3 ? aiPrimitiveType_TRIANGLE
                                       : aiPrimitiveType_POLYGON;
      if (kept != i) mesh.mFaces[kept] = face;
      ++kept;
    }
    empty += mesh.mNumFaces - kept;
    mesh.mNumFaces = kept;
    mesh.mPrimitiveTypes = types;  // assimp counts an empty face as a polygon
  }
  return empty;
}

/// Cuts polygons that are not strictly convex into triangles. If several corners of a polygon lie
/// on one line, assimp makes flat and overlapping triangles of it. They leave edges where there are
/// none. A polygon that cannot be cut here is left to assimp.
void cutPolygons(aiMesh* mesh) {
  std::vector<aiFace> faces;
  bool any = false;
  for (unsigned i = 0; i < mesh->mNumFaces; ++i) {
    const aiFace& face = mesh->mFaces[i];
    std::vector<std::array<unsigned, 3>> triangles;
    if (face.mNumIndices > 3) {
      std::vector<Eigen::Vector3d> corners;
      for (unsigned k = 0; k < face.mNumIndices; ++k) {
        const aiVector3D& v = mesh->mVertices[face.mIndices[k]];
        corners.emplace_back(v.x, v.y, v.z);
      }
      if (!isStrictlyConvex(corners)) triangles = cutEars(corners);
    }
    if (triangles.empty()) faces.push_back(face);
    for (const auto& [a, b, c] : triangles) {
      faces.emplace_back();
      faces.back().mNumIndices = 3;
      faces.back().mIndices =
          // Face deletes it.
          new unsigned[3]{face.mIndices[a], face.mIndices[b], face.mIndices[c]};
      any = true;
    }
  }
  if (!any) return;
  // assimp ends the process when a mesh is marked as having polygons but has none.
  mesh->mPrimitiveTypes |= aiPrimitiveType_TRIANGLE;
  if (std::none_of(faces.begin(), faces.end(),
                   [](const aiFace& face) { return face.mNumIndices > 3; }))
    mesh->mPrimitiveTypes &= ~static_cast<unsigned>(aiPrimitiveType_POLYGON);
  delete[] mesh->mFaces;
  mesh->mNumFaces = static_cast<unsigned>(faces.size());
  mesh->mFaces = new aiFace[faces.size()];
  std::copy(faces.begin(), faces.end(), mesh->mFaces);
}

/// Reads the parts of a scene into a model.
class SceneParts {
 public:
  /// @param to_file turns assimp's axes to those of the file.
  /// @param shift was subtracted from the vertices of every mesh.
  SceneParts(const aiScene& scene, Eigen::Matrix3d to_file, Eigen::Vector3d shift, RawModel* model)
      : scene_(scene), to_file_(std::move(to_file)), shift_(std::move(shift)), model_(model) {}

  /// @param parent transform of the parent node. It is double, so that vertices far from the origin
  ///   keep their accuracy.
  void append(const aiNode& node, const Eigen::Affine3d& parent, int depth = 0) {
    constexpr int kDeepest = 1000;  // a deeper tree would exhaust the stack
    if (depth > kDeepest) throw InputError("the tree of parts is too deep");
    const Eigen::Affine3d to_root = parent * transformOf(node.mTransformation);
    for (unsigned i = 0; i < node.mNumMeshes; ++i)
      if (node.mMeshes[i] < scene_.mNumMeshes)
        appendMesh(*scene_.mMeshes[node.mMeshes[i]], objectNumber(node, node.mMeshes[i]), to_root);
    for (unsigned i = 0; i < node.mNumChildren; ++i) append(*node.mChildren[i], to_root, depth + 1);
  }

 private:
  static Eigen::Affine3d transformOf(const aiMatrix4x4& m) {
    Eigen::Affine3d transform;
    transform.matrix() << m.a1, m.a2, m.a3, m.a4, m.b1, m.b2, m.b3, m.b4, m.c1, m.c2, m.c3, m.c4, 0,
        0, 0, 1;
    return transform;
  }

  /// Number of the object of a mesh. Its name is that of the node, else that of the mesh.
  uint32_t objectNumber(const aiNode& node, unsigned mesh) {
    std::string name = node.mName.C_Str();
    if (name.empty() || &node == scene_.mRootNode) name = scene_.mMeshes[mesh]->mName.C_Str();
    if (name.empty()) name = "unnamed";
    const auto [it, is_new] = numbers_.emplace(name, static_cast<uint32_t>(model_->objects.size()));
    if (is_new) model_->objects.push_back(name);
    return it->second;
  }

  void appendMesh(const aiMesh& mesh, uint32_t object, const Eigen::Affine3d& to_root) {
    constexpr float kPrecision = 1.2e-7f;  // of single precision
    const auto scale = static_cast<float>(to_root.linear().norm() / std::sqrt(3.0));
    const auto of_transform = static_cast<float>(to_root.translation().cwiseAbs().maxCoeff());
    const auto offset = static_cast<uint32_t>(model_->vertices.size());
    for (unsigned i = 0; i < mesh.mNumVertices; ++i) {
      const aiVector3D& v = mesh.mVertices[i];
      model_->vertices.push_back(to_file_ * (to_root * Eigen::Vector3d(v.x, v.y, v.z)) +
                                 to_file_ * (to_root.linear() * shift_));
      const float largest = std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
      const float rounding = kPrecision * std::max(scale * largest, of_transform);
      // A vertex that is not finite is an error that others tell.
      model_->rounding.push_back(std::isfinite(rounding) ? rounding : 0);
    }
    for (unsigned i = 0; i < mesh.mNumFaces; ++i) {
      const aiFace& face = mesh.mFaces[i];
      if (face.mNumIndices == 2) {
        model_->lines.push_back({offset + face.mIndices[0], offset + face.mIndices[1]});
        model_->line_object.push_back(object);
      } else if (face.mNumIndices == 3) {
        model_->triangles.push_back(
            {offset + face.mIndices[0], offset + face.mIndices[1], offset + face.mIndices[2]});
        model_->triangle_material.push_back(
            std::min(mesh.mMaterialIndex, std::max(1u, scene_.mNumMaterials) - 1));
        model_->triangle_object.push_back(object);
      }
    }
  }

  const aiScene& scene_;
  Eigen::Matrix3d to_file_;
  Eigen::Vector3d shift_;
  RawModel* model_;
  std::map<std::string, uint32_t> numbers_;
};

/// Rotation that undoes assimp's change of axes. The map keeps the axes of the file. If z is up in
/// a format, assimp turns the coordinates so that y is up.
Eigen::Matrix3d fileAxes(const std::string& extension) {
  constexpr std::array<std::string_view, 6> kTurned{".ifc", ".ifczip", ".dxf",
                                                    ".3ds", ".ase",    ".ask"};
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  if (std::find(kTurned.begin(), kTurned.end(), extension) != kTurned.end())
    turn << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  return turn;
}

void readMaterials(const aiScene& scene, RawModel* model) {
  for (unsigned m = 0; m < scene.mNumMaterials; ++m) {
    aiColor3D color(0.7f, 0.7f, 0.7f);
    scene.mMaterials[m]->Get(AI_MATKEY_COLOR_DIFFUSE, color);
    Eigen::Vector3f rgb(color.r, color.g, color.b);
    if (!rgb.allFinite()) rgb.setConstant(0.7f);
    model->material_colors.emplace_back(rgb.cwiseMax(0).cwiseMin(1));
  }
  if (model->material_colors.empty()) model->material_colors.emplace_back(0.7f, 0.7f, 0.7f);
}

/// Unit and upward axis of an FBX file. Its unit is a multiple of the centimetre.
void readFbxFacts(const aiScene& scene, RawModel* model) {
  if (!scene.mMetaData) return;
  // assimp 5.2 stores the factor as a float or as a double.
  float single = 0;
  double factor = 0;
  if (!scene.mMetaData->Get("UnitScaleFactor", factor) &&
      scene.mMetaData->Get("UnitScaleFactor", single))
    factor = static_cast<double>(single);
  if (std::isfinite(factor) && factor > 0) {
    model->unit = 0.01 * factor;
    model->unit_name = factor == 1       ? "centimetre"
                       : factor == 0.1   ? "millimetre"
                       : factor == 100   ? ""
                       : factor == 2.54  ? "inch"
                       : factor == 30.48 ? "foot"
                                         : "unit of " + std::to_string(model->unit) + " m";
  }
  int32_t up = -1;
  if (scene.mMetaData->Get("UpAxis", up) && up >= 0 && up <= 2) model->up_axis = up;
}

std::string reasonOf(const Assimp::Importer& importer) {
  const std::string reason = importer.GetErrorString();
  return reason.empty() ? "assimp gives no reason; the file is broken or empty" : reason;
}

/// Reads a file as it is, or with the contents and the shift of `shifted`.
RawModel readParts(const std::string& file, const FileUnit& unit,
                   std::optional<ShiftedFile> shifted) {
  const std::string extension = extensionOf(file);
  RawModel model;
  model.unit = unit.metres;
  model.unit_name = unit.name;
  model.in_metres = unit.is_applied;
  const Eigen::Vector3d shift = shifted ? shifted->shift : Eigen::Vector3d::Zero();
  Assimp::Importer importer;
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);
  // The importer deletes it.
  importer.SetIOHandler(shifted ? new GuardedFileSystem(file, std::move(shifted->contents))
                                : new GuardedFileSystem);
  // Comments, vertex colours and texture coordinates are not needed. Faces become triangles, but
  // line elements stay.
  const aiScene* scene = nullptr;
  try {
    scene = importer.ReadFile(file, 0);
    if (scene) {
      // The importer owns the scene and gives it out as const, hence the cast.
      model.empty_faces = prepareForTriangulation(const_cast<aiScene*>(scene), file);
      for (unsigned m = 0; m < scene->mNumMeshes; ++m) cutPolygons(scene->mMeshes[m]);
      scene = importer.ApplyPostProcessing(aiProcess_Triangulate);
    }
  } catch (const InputError&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& e) {
    throw InputError(file + ": not readable as a 3D model: " + e.what());
  }
  // assimp turns the exception into a text.
  if (!scene && std::string(importer.GetErrorString()).find("bad_alloc") != std::string::npos)
    throw std::bad_alloc();
  if (!scene || !scene->mRootNode)
    throw InputError(file + ": not readable as a 3D model: " + reasonOf(importer));
  readMaterials(*scene, &model);
  if (extension == ".fbx") readFbxFacts(*scene, &model);
  // In an IFC file the far points are placements. assimp has made metres of its coordinates.
  const bool is_ifc = extension == ".ifc";
  SceneParts(*scene, fileAxes(extension), is_ifc ? Eigen::Vector3d::Zero() : shift, &model)
      .append(*scene->mRootNode, Eigen::Affine3d::Identity());
  if (is_ifc)
    for (Eigen::Vector3d& v : model.vertices) v += (unit.is_applied ? unit.metres : 1) * shift;
  return model;
}

/// Whether all vertices have the same place within the errors of rounding.
bool isSamePlace(const RawModel& a, const RawModel& b) {
  if (a.vertices.size() != b.vertices.size()) return false;
  for (size_t i = 0; i < a.vertices.size(); ++i) {
    // Placements are multiplied, so their errors add up.
    constexpr double kErrors = 20;
    const double most = kErrors * static_cast<double>(a.rounding[i] + b.rounding[i]) + 1e-3;
    if (!((a.vertices[i] - b.vertices[i]).cwiseAbs().maxCoeff() <= most)) return false;
  }
  return true;
}

}  // namespace

RawModel readScene(const std::string& file) {
  const std::string extension = extensionOf(file);
  if (extension == ".ply") checkPlyHeader(file);
  const FileUnit unit = statedUnit(file);
  std::optional<ShiftedFile> shifted = shiftedNearOrigin(file);
  const bool is_far = shifted && !shifted->shift.isZero();
  RawModel model = readParts(file, unit, std::move(shifted));
  if (!is_far || extension != ".ifc") return model;
  // A far point of an IFC file may be the placement of the site, of one object, of a rotated child
  // or of nothing. Only when the shift has moved all objects alike is it one of the model.
  RawModel as_it_is = readParts(file, unit, std::nullopt);
  return isSamePlace(model, as_it_is) ? std::move(model) : std::move(as_it_is);
}

}  // namespace edge_mcl
