// Reads mesh files through assimp.
#include <assimp/config.h>
#include <assimp/material.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <assimp/Importer.hpp>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <string_view>

#include "edge_mcl/core/base/angles.h"
#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/base/se3.h"
#include "edge_mcl/core/mesh/guarded_file_system.h"
#include "edge_mcl/core/mesh/mesh_model.h"
#include "edge_mcl/core/mesh/ply_header.h"
#include "edge_mcl/core/mesh/polygon_ears.h"

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

/// Rounding error of the vertex that is nearest to the file's origin, m. Coordinates are read in
/// single precision, so vertices far from the origin are coarse. The nearest vertex decides, so
/// that a few far vertices do not count.
double coarsenessOf(const MeshSoup& soup, const MapParameters& params,
                    const Eigen::Affine3d& to_map) {
  constexpr double kPrecision = 1.2e-7;
  const Eigen::Affine3d to_file = to_map.inverse();
  double nearest = INFINITY;
  for (const Eigen::Vector3f& v : soup.vertices)
    nearest = std::min(nearest, (to_file * v.cast<double>()).cwiseAbs().maxCoeff());
  return kPrecision * nearest * params.scale;
}

void appendMesh(const aiMesh& mesh, const aiMatrix4x4& to_root, const Eigen::Affine3d& to_map,
                MeshSoup* soup) {
  const auto offset = static_cast<uint32_t>(soup->vertices.size());
  for (unsigned i = 0; i < mesh.mNumVertices; ++i) {
    const aiVector3D v = to_root * mesh.mVertices[i];
    soup->vertices.push_back((to_map * Eigen::Vector3d(v.x, v.y, v.z)).cast<float>());
  }
  for (unsigned i = 0; i < mesh.mNumFaces; ++i) {
    const aiFace& face = mesh.mFaces[i];
    if (face.mNumIndices == 2) {
      soup->lines.push_back({offset + face.mIndices[0], offset + face.mIndices[1]});
    } else if (face.mNumIndices == 3) {
      soup->triangles.push_back(
          {offset + face.mIndices[0], offset + face.mIndices[1], offset + face.mIndices[2]});
      soup->triangle_material.push_back(mesh.mMaterialIndex);
    }
  }
}

void appendNode(const aiScene& scene, const aiNode& node, const aiMatrix4x4& parent,
                const Eigen::Affine3d& to_map, MeshSoup* soup) {
  const aiMatrix4x4 to_root = parent * node.mTransformation;
  for (unsigned i = 0; i < node.mNumMeshes; ++i)
    if (node.mMeshes[i] < scene.mNumMeshes)
      appendMesh(*scene.mMeshes[node.mMeshes[i]], to_root, to_map, soup);
  for (unsigned i = 0; i < node.mNumChildren; ++i)
    appendNode(scene, *node.mChildren[i], to_root, to_map, soup);
}

Eigen::Affine3d mapTransform(const MapParameters& params) {
  Eigen::Affine3d transform = Eigen::Affine3d::Identity();
  transform.translate(Eigen::Vector3d(params.x, params.y, params.z));
  transform.rotate(rotationFromAngles(params.roll_deg * kDegree, params.pitch_deg * kDegree,
                                      params.yaw_deg * kDegree));
  transform.scale(params.scale);
  return transform;
}

/// Rotation that undoes assimp's change of axes. The map keeps the axes of the file. If z is up in
/// a format, assimp turns the coordinates so that y is up.
Eigen::Affine3d fileAxes(const std::string& extension) {
  constexpr std::array<std::string_view, 6> kTurned{".ifc", ".ifczip", ".dxf",
                                                    ".3ds", ".ase",    ".ask"};
  Eigen::Affine3d turn = Eigen::Affine3d::Identity();
  if (std::find(kTurned.begin(), kTurned.end(), extension) != kTurned.end())
    turn.linear() << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  return turn;
}

void addScaleWarnings(MeshModel* mesh) {
  const double diagonal = mesh->diagonal();
  if (diagonal > 500)
    mesh->report.warnings.push_back("the model is " + std::to_string(std::lround(diagonal)) +
                                    " m across. Is it in millimetres? Then set map.scale to 0.001");
  if (diagonal < 0.02)
    mesh->report.warnings.push_back("the model is less than 2 cm across. Is map.scale right?");
  if (mesh->report.degenerate_triangles > 0)
    mesh->report.warnings.push_back(std::to_string(mesh->report.degenerate_triangles) +
                                    " degenerate triangles dropped");
  if (mesh->report.duplicate_triangles > 0)
    mesh->report.warnings.push_back(std::to_string(mesh->report.duplicate_triangles) +
                                    " duplicate triangles dropped");
  if (mesh->report.zero_length_lines > 0)
    mesh->report.warnings.push_back(std::to_string(mesh->report.zero_length_lines) +
                                    " lines without length dropped");
}

}  // namespace

MeshModel loadMesh(const std::string& file, const MapParameters& params) {
  std::error_code ignored;
  if (std::filesystem::is_directory(file, ignored)) throw InputError(file + ": is a directory");
  if (!std::ifstream(file)) throw InputError(file + ": cannot be read");
  std::string extension = std::filesystem::path(file).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (extension == ".ply") checkPlyHeader(file);
  MeshSoup soup;
  size_t empty_faces = 0;
  {
    Assimp::Importer importer;
    importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);
    importer.SetIOHandler(new GuardedFileSystem);  // the importer deletes it
    // Comments, vertex colours and texture coordinates are not needed. Faces become triangles, but
    // line elements stay.
    const aiScene* scene = nullptr;
    try {
      scene = importer.ReadFile(file, 0);
      if (scene) {
        // The importer owns the scene and gives it out as const, hence the cast.
        empty_faces = prepareForTriangulation(const_cast<aiScene*>(scene), file);
        for (unsigned m = 0; m < scene->mNumMeshes; ++m) cutPolygons(scene->mMeshes[m]);
        scene = importer.ApplyPostProcessing(aiProcess_Triangulate);
      }
    } catch (const InputError&) {
      throw;
    } catch (const std::exception& e) {
      throw InputError(file + ": not readable as a 3D model: " + e.what());
    }
    if (!scene || !scene->mRootNode)
      throw InputError(file + ": not readable as a 3D model: " + importer.GetErrorString());
    soup.material_count = std::max(1u, scene->mNumMaterials);
    for (unsigned m = 0; m < scene->mNumMaterials; ++m) {
      aiColor3D color(0.7f, 0.7f, 0.7f);
      scene->mMaterials[m]->Get(AI_MATKEY_COLOR_DIFFUSE, color);
      Eigen::Vector3f rgb(color.r, color.g, color.b);
      if (!rgb.allFinite()) rgb.setConstant(0.7f);
      soup.material_colors.emplace_back(rgb.cwiseMax(0).cwiseMin(1));
    }
    appendNode(*scene, *scene->mRootNode, aiMatrix4x4(), mapTransform(params) * fileAxes(extension),
               &soup);
  }
  if (soup.vertices.empty()) throw InputError(file + ": the model has no vertices");
  const double coarseness = coarsenessOf(soup, params, mapTransform(params) * fileAxes(extension));
  const std::string far_off =
      "the model is so far from the origin of its file that its coordinates have an error of " +
      std::to_string(std::lround(1000 * std::min(coarseness, 1e6))) +
      " mm. Move it near the origin in the file (map.x, map.y and map.z do not help)";
  if (std::isfinite(coarseness) && coarseness > 0.01) throw InputError(file + ": " + far_off);
  double tolerance = params.weld_tolerance;
  if (tolerance <= 0) {
    Eigen::Vector3f low = soup.vertices.front(), high = low;
    for (const auto& v : soup.vertices) {
      low = low.cwiseMin(v);
      high = high.cwiseMax(v);
    }
    const double diagonal = (high - low).cast<double>().norm();
    tolerance = std::isfinite(diagonal) ? std::clamp(1e-6 * diagonal, 1e-7, 1e-4) : 1e-7;
  }
  MeshModel mesh = weldMesh(std::move(soup), tolerance, file);
  mesh.report.degenerate_triangles += empty_faces;
  if (coarseness > 0.001) mesh.report.warnings.push_back(far_off);
  addScaleWarnings(&mesh);
  return mesh;
}

}  // namespace edge_mcl
