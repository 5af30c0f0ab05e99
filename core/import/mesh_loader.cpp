#include "edge_mcl/core/import/mesh_loader.h"

#include <fnmatch.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <utility>

#include "edge_mcl/core/base/angles.h"
#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/base/se3.h"
#include "edge_mcl/core/import/file_facts.h"
#include "edge_mcl/core/import/importer_process.h"

namespace edge_mcl {

namespace {

Eigen::Affine3d mapTransform(const MapParameters& params, double scale) {
  Eigen::Affine3d transform = Eigen::Affine3d::Identity();
  transform.translate(Eigen::Vector3d(params.x, params.y, params.z));
  transform.rotate(rotationFromAngles(params.roll_deg * kDegree, params.pitch_deg * kDegree,
                                      params.yaw_deg * kDegree));
  Eigen::Vector3d axes = Eigen::Vector3d::Constant(scale);
  for (int k = 0; k < 3; ++k)
    if (params.mirror == std::string(1, "xyz"[k])) axes[k] = -scale;
  transform.scale(axes);
  return transform;
}

/// Patterns that are separated by commas.
std::vector<std::string> patternsOf(const std::string& text) {
  std::vector<std::string> list;
  std::istringstream in(text);
  for (std::string pattern; std::getline(in, pattern, ',');) {
    pattern.erase(0, pattern.find_first_not_of(' '));
    pattern.erase(pattern.find_last_not_of(' ') + 1);
    if (!pattern.empty()) list.push_back(pattern);
  }
  return list;
}

bool matchesOne(const std::string& name, const std::vector<std::string>& patterns) {
  return std::any_of(patterns.begin(), patterns.end(), [&](const std::string& pattern) {
    return fnmatch(pattern.c_str(), name.c_str(), FNM_CASEFOLD) == 0;
  });
}

/// Drops the objects that map.include and map.exclude leave out.
/// @throws InputError when a pattern matches no object, which is a typing error.
void chooseObjects(const MapParameters& params, const std::string& file, RawModel* model) {
  const std::vector<std::string> include = patternsOf(params.include);
  const std::vector<std::string> exclude = patternsOf(params.exclude);
  if (include.empty() && exclude.empty()) return;
  const auto requireMatch = [&](const std::string& pattern) {
    if (std::none_of(model->objects.begin(), model->objects.end(),
                     [&](const std::string& name) { return matchesOne(name, {pattern}); }))
      throw InputError(file + ": no object has a name like '" + pattern +
                       "' (edge-mcl inspect --objects lists the names)");
  };
  std::for_each(include.begin(), include.end(), requireMatch);
  std::for_each(exclude.begin(), exclude.end(), requireMatch);
  std::vector<bool> keep;
  for (const std::string& name : model->objects)
    keep.push_back((include.empty() || matchesOne(name, include)) && !matchesOne(name, exclude));
  RawModel chosen = *model;
  chosen.triangles.clear();
  chosen.triangle_material.clear();
  chosen.triangle_object.clear();
  chosen.lines.clear();
  chosen.line_object.clear();
  for (size_t i = 0; i < model->triangles.size(); ++i)
    if (keep[model->triangle_object[i]]) {
      chosen.triangles.push_back(model->triangles[i]);
      chosen.triangle_material.push_back(model->triangle_material[i]);
      chosen.triangle_object.push_back(model->triangle_object[i]);
    }
  for (size_t i = 0; i < model->lines.size(); ++i)
    if (keep[model->line_object[i]]) {
      chosen.lines.push_back(model->lines[i]);
      chosen.line_object.push_back(model->line_object[i]);
    }
  if (chosen.triangles.empty() && chosen.lines.empty())
    throw InputError(file + ": map.include and map.exclude leave nothing of the model");
  *model = std::move(chosen);
}

/// Origin of the map frame: near the model, when the model is far from the file's origin.
Eigen::Vector3d originOf(const MapParameters& params, const Eigen::Vector3d& lowest,
                         const Eigen::Vector3d& highest) {
  if (const auto given = params.givenOrigin()) return Eigen::Vector3d(given->data());
  // Single precision is good to 0.25 mm at this distance.
  constexpr double kFar = 5000, kRound = 100;
  Eigen::Vector3d nearest;
  for (int k = 0; k < 3; ++k)
    nearest[k] = lowest[k] > 0 ? lowest[k] : highest[k] < 0 ? highest[k] : 0;
  if (nearest.cwiseAbs().maxCoeff() < kFar) return Eigen::Vector3d::Zero();
  return (lowest / kRound).array().round().matrix() * kRound;
}

std::string metresText(const Eigen::Vector3d& v) {
  std::ostringstream text;
  text.precision(12);
  text << "(" << v.x() << ", " << v.y() << ", " << v.z() << ")";
  return text.str();
}

void addSizeWarnings(double scale, MeshModel* mesh) {
  std::vector<std::string>& warnings = mesh->report.warnings;
  const double diagonal = mesh->diagonal();
  if (diagonal < 0.02)
    warnings.emplace_back("the model is less than 2 cm across. Is map.scale right?");
  if (scale == 1 && diagonal > 500)
    warnings.push_back("the model is " + std::to_string(std::lround(diagonal)) +
                       " m across. Is it in centimetres or millimetres? Then set map.scale to 0.01 "
                       "or 0.001");
  const auto count = [&](size_t n, const char* what) {
    if (n > 0) warnings.push_back(std::to_string(n) + what);
  };
  count(mesh->report.degenerate_triangles, " degenerate triangles dropped");
  count(mesh->report.duplicate_triangles, " duplicate triangles dropped");
  count(mesh->report.zero_length_lines, " lines without length dropped");
}

/// The model's parts in the map frame, and the origin of the map frame.
MeshSoup soupOf(RawModel raw, const Eigen::Affine3d& to_map, const MapParameters& params,
                Eigen::Vector3d* origin) {
  Eigen::Vector3d low = Eigen::Vector3d::Constant(INFINITY), high = -low;
  for (Eigen::Vector3d& v : raw.vertices) {
    v = to_map * v;
    if (!v.allFinite()) continue;  // an error that weldMesh() tells
    low = low.cwiseMin(v);
    high = high.cwiseMax(v);
  }
  *origin = originOf(params, low, high);
  MeshSoup soup;
  soup.vertices.reserve(raw.vertices.size());
  for (const Eigen::Vector3d& v : raw.vertices)
    soup.vertices.push_back((v - *origin).cast<float>());
  if (std::find(raw.objects.begin(), raw.objects.end(), kHidingFaces) != raw.objects.end())
    for (const uint32_t object : raw.triangle_object)
      soup.hides_only.push_back(raw.objects[object] == kHidingFaces);
  soup.triangles = std::move(raw.triangles);
  soup.triangle_material = std::move(raw.triangle_material);
  soup.lines = std::move(raw.lines);
  soup.material_count = static_cast<uint32_t>(raw.material_colors.size());
  soup.material_colors = std::move(raw.material_colors);
  return soup;
}

double weldTolerance(const MeshSoup& soup) {
  Eigen::Vector3f low = soup.vertices.front(), high = low;
  for (const auto& v : soup.vertices) {
    low = low.cwiseMin(v);
    high = high.cwiseMax(v);
  }
  const double diagonal = (high - low).cast<double>().norm();
  return std::isfinite(diagonal) ? std::clamp(1e-6 * diagonal, 1e-7, 1e-4) : 1e-7;
}

}  // namespace

MeshModel loadMesh(const std::string& file, const MapParameters& params) {
  std::error_code ignored;
  if (std::filesystem::is_directory(file, ignored)) throw InputError(file + ": is a directory");
  if (std::filesystem::exists(file, ignored) && !std::filesystem::is_regular_file(file, ignored))
    throw InputError(file + ": is not a regular file");
  if (!std::ifstream(file)) throw InputError(file + ": cannot be read");
  requireReadableFormat(file);
  RawModel raw = importModel(file, {params.import_seconds, params.import_gigabytes});
  if (raw.vertices.empty()) throw InputError(file + ": the model has no vertices");
  chooseObjects(params, file, &raw);
  std::map<std::string, size_t> objects;
  for (const uint32_t i : raw.triangle_object) ++objects[raw.objects[i]];
  for (const uint32_t i : raw.line_object) ++objects[raw.objects[i]];
  const double scale = params.scale > 0 ? params.scale : raw.unit > 0 ? raw.unit : 1;
  const double rounding = raw.rounding * scale;
  const std::string coarse =
      "the file is so far from its origin that its coordinates are rounded to " +
      std::to_string(std::lround(1000 * std::min(rounding, 1e6))) +
      " mm. Move the model near the origin, or export it as OBJ or as PLY in double precision";
  if (rounding > 0.01) throw InputError(file + ": " + coarse);
  const std::string unit = raw.unit_name;
  const double file_unit = raw.unit;
  const int up_axis = raw.up_axis;
  const size_t empty_faces = raw.empty_faces;
  Eigen::Vector3d origin;
  MeshSoup soup = soupOf(std::move(raw), mapTransform(params, scale), params, &origin);
  const double tolerance = params.weld_tolerance > 0 ? params.weld_tolerance : weldTolerance(soup);
  MeshModel mesh = weldMesh(std::move(soup), tolerance, file);
  mesh.origin = origin;
  mesh.report.objects = std::move(objects);
  mesh.report.degenerate_triangles += empty_faces;
  std::vector<std::string>& warnings = mesh.report.warnings;
  if (rounding > 0.001) warnings.push_back(coarse);
  if (endsTooEarly(file))
    warnings.emplace_back(
        "the file lacks the mark at its end. Was it cut off? Then a part of the model is missing");
  if (!unit.empty()) {
    mesh.report.unit = unit;
    if (params.scale > 0 && std::abs(params.scale / file_unit - 1) > 1e-6)
      warnings.push_back("the file's unit is the " + unit + ", and map.scale overrides it");
  }
  if (!origin.isZero())
    warnings.push_back("the map's origin is at " + metresText(origin) +
                       " in the file's coordinates, m (see map.origin)");
  if (up_axis >= 0 && up_axis < 2)
    warnings.push_back(std::string("the file says that its ") + "xyz"[up_axis] + " axis is up. " +
                       (up_axis == 1 ? "map.roll_deg=90" : "map.pitch_deg=-90") +
                       " makes z the upward axis");
  addSizeWarnings(scale, &mesh);
  return mesh;
}

}  // namespace edge_mcl
