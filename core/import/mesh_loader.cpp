#include "edge_mcl/core/import/mesh_loader.h"

#include <fnmatch.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <utility>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/import/file_facts.h"
#include "edge_mcl/core/import/importer_process.h"
#include "edge_mcl/core/import/map_frame.h"

namespace edge_mcl {

namespace {

/// A file of map.additions.
struct Addition {
  std::string file;
  RawModel model;
};

/// Patterns or files that are separated by commas.
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

/// Whether a name matches a pattern, in which * is any text and ? is one character. Names of
/// building models hold brackets and backslashes, which fnmatch() would take for more.
bool matches(const std::string& name, const std::string& pattern) {
  std::string literal;
  for (const char c : pattern) {
    if (c == '[' || c == ']' || c == '\\') literal += '\\';
    literal += c;
  }
  return fnmatch(literal.c_str(), name.c_str(), FNM_CASEFOLD) == 0;
}

bool matchesOne(const std::string& name, const std::vector<std::string>& patterns) {
  return std::any_of(patterns.begin(), patterns.end(),
                     [&](const std::string& pattern) { return matches(name, pattern); });
}

/// Drops objects. @param keep one entry for each object
void keepObjects(const std::vector<bool>& keep, RawModel* model) {
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
  *model = std::move(chosen);
}

/// Drops the objects that map.include and map.exclude leave out. map.include speaks of the model
/// only: who adds a file wants what it holds.
/// @throws InputError when a pattern matches no object, which is a typing error.
void chooseObjects(const MapParameters& params, const std::string& file, RawModel* model,
                   std::vector<Addition>* additions) {
  const std::vector<std::string> include = patternsOf(params.include);
  const std::vector<std::string> exclude = patternsOf(params.exclude);
  if (include.empty() && exclude.empty()) return;
  const auto holds = [](const RawModel& m, const std::string& pattern) {
    return std::any_of(m.objects.begin(), m.objects.end(),
                       [&](const std::string& name) { return matches(name, pattern); });
  };
  const auto fail = [&](const std::string& pattern) {
    throw InputError(file + ": no object has a name like '" + pattern +
                     "' (edge-mcl inspect --objects lists the names)");
  };
  for (const std::string& pattern : include)
    if (!holds(*model, pattern)) fail(pattern);
  for (const std::string& pattern : exclude)
    if (!holds(*model, pattern) &&
        std::none_of(additions->begin(), additions->end(),
                     [&](const Addition& addition) { return holds(addition.model, pattern); }))
      fail(pattern);
  std::vector<bool> keep;
  for (const std::string& name : model->objects)
    keep.push_back((include.empty() || matchesOne(name, include)) && !matchesOne(name, exclude));
  keepObjects(keep, model);
  if (model->triangles.empty() && model->lines.empty())
    throw InputError(file + ": map.include and map.exclude leave nothing of the model");
  for (Addition& addition : *additions) {
    keep.clear();
    for (const std::string& name : addition.model.objects)
      keep.push_back(!matchesOne(name, exclude));
    keepObjects(keep, &addition.model);
  }
}

/// Drops vertices of which no triangle or line is made. They must not place the origin.
void dropUnusedVertices(RawModel* model) {
  constexpr uint32_t kUnused = 0xffffffffu;
  std::vector<uint32_t> number(model->vertices.size(), kUnused);
  uint32_t count = 0;
  const auto use = [&](uint32_t* vertex) {
    if (number[*vertex] == kUnused) number[*vertex] = count++;
    *vertex = number[*vertex];
  };
  for (auto& triangle : model->triangles)
    for (uint32_t& vertex : triangle) use(&vertex);
  for (auto& line : model->lines)
    for (uint32_t& vertex : line) use(&vertex);
  if (count == 0) return;  // an error that weldMesh() tells
  std::vector<Eigen::Vector3d> used(count);
  std::vector<float> rounding(count);
  for (size_t i = 0; i < number.size(); ++i)
    if (number[i] != kUnused) {
      used[number[i]] = model->vertices[i];
      rounding[number[i]] = model->rounding[i];
    }
  model->vertices = std::move(used);
  model->rounding = std::move(rounding);
}

/// @throws InputError when the vertices are too coarse. @param scale metres per unit of them.
/// @return a warning, or an empty text.
std::string coarseness(const RawModel& model, double scale, const std::string& file) {
  constexpr double kBad = 0.01, kNoticed = 0.001;  // m
  std::vector<float> rounding = model.rounding;
  if (rounding.empty()) return "";
  const auto coarse = std::count_if(rounding.begin(), rounding.end(), [&](float r) {
    return scale * static_cast<double>(r) > kNoticed;
  });
  if (coarse == 0) return "";
  const double most =
      scale * static_cast<double>(*std::max_element(rounding.begin(), rounding.end()));
  const auto middle = rounding.begin() + static_cast<std::ptrdiff_t>(rounding.size() / 2);
  std::nth_element(rounding.begin(), middle, rounding.end());
  std::string text =
      std::to_string(coarse) + " of " + std::to_string(rounding.size()) +
      " vertices are rounded, by up to " + std::to_string(std::lround(1000 * std::min(most, 1e6))) +
      " mm, since they are far from the origin of the file or from most of its vertices. Export "
      "their objects to another file, near its origin or as OBJ or PLY in double precision";
  if (scale * static_cast<double>(*middle) > kBad) throw InputError(file + ": " + text);
  return text;
}

/// @param is_unit_known whether the file or the user says what a unit of the file is.
void addSizeWarnings(bool is_unit_known, MeshModel* mesh) {
  std::vector<std::string>& warnings = mesh->report.warnings;
  const double diagonal = mesh->diagonal();
  if (diagonal < 0.02)
    warnings.emplace_back("the model is less than 2 cm across. Is map.scale right?");
  const std::string doubt = is_unit_known ? "" : sizeDoubt(diagonal);
  if (!doubt.empty()) warnings.push_back(doubt);
  const auto count = [&](size_t n, const char* what) {
    if (n > 0) warnings.push_back(std::to_string(n) + what);
  };
  count(mesh->report.degenerate_triangles, " degenerate triangles dropped");
  count(mesh->report.duplicate_triangles, " duplicate triangles dropped");
  count(mesh->report.zero_length_lines, " lines without length dropped");
}

bool hidesOnly(const std::string& object) {
  const std::string name = kHidingFaces;
  return object.size() >= name.size() &&
         object.compare(object.size() - name.size(), name.size(), name) == 0 &&
         (object.size() == name.size() || object[object.size() - name.size() - 1] == '_');
}

/// Appends the parts of a model whose vertices are in the map frame before the origin is
/// subtracted.
void append(RawModel raw, const Eigen::Vector3d& origin, MeshSoup* soup) {
  const auto first = static_cast<uint32_t>(soup->vertices.size());
  const uint32_t first_material = soup->material_count;
  const bool hides = std::any_of(raw.triangle_object.begin(), raw.triangle_object.end(),
                                 [&](uint32_t object) { return hidesOnly(raw.objects[object]); });
  if (hides || !soup->hides_only.empty()) {
    soup->hides_only.resize(soup->triangles.size(), false);
    for (const uint32_t object : raw.triangle_object)
      soup->hides_only.push_back(hidesOnly(raw.objects[object]));
  }
  for (const Eigen::Vector3d& v : raw.vertices)
    soup->vertices.push_back((v - origin).cast<float>());
  for (auto& triangle : raw.triangles) {
    for (uint32_t& vertex : triangle) vertex += first;
    soup->triangles.push_back(triangle);
  }
  for (const uint32_t material : raw.triangle_material)
    soup->triangle_material.push_back(first_material + material);
  for (auto& line : raw.lines) {
    for (uint32_t& vertex : line) vertex += first;
    soup->lines.push_back(line);
  }
  soup->material_count += static_cast<uint32_t>(raw.material_colors.size());
  soup->material_colors.insert(soup->material_colors.end(), raw.material_colors.begin(),
                               raw.material_colors.end());
}

/// The model's parts in the map frame, and the origin of the map frame.
MeshSoup soupOf(RawModel raw, const Eigen::Affine3d& to_map, const MapParameters& params,
                Eigen::Vector3d* origin) {
  std::vector<Eigen::Vector3d> finite;
  finite.reserve(raw.vertices.size());
  for (Eigen::Vector3d& v : raw.vertices) {
    v = to_map * v;
    if (v.allFinite()) finite.push_back(v);  // others are an error that weldMesh() tells
  }
  *origin = mapOrigin(params, finite);
  MeshSoup soup;
  soup.vertices.reserve(raw.vertices.size());
  soup.material_count = 0;
  append(std::move(raw), *origin, &soup);
  return soup;
}

/// @param scale map.scale
void addUnit(const FileUnit& unit, double scale, MeshReport* report) {
  if (unit.name.empty()) return;
  report->unit = unit.name;
  if (scale > 0 && std::abs(scale / unit.metres - 1) > 1e-6)
    report->warnings.push_back("the file's unit is the " + unit.name +
                               ", and map.scale overrides it");
  else if (scale == 0 && unit.metres <= 0)
    report->warnings.push_back("the file's unit is the " + unit.name +
                               ", whose length is not known here. Its coordinates are taken for "
                               "metres; map.scale sets another unit");
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

RawModel readFile(const std::string& file, const MapParameters& params) {
  std::error_code ignored;
  if (std::filesystem::is_directory(file, ignored)) throw InputError(file + ": is a directory");
  if (std::filesystem::exists(file, ignored) && !std::filesystem::is_regular_file(file, ignored))
    throw InputError(file + ": is not a regular file");
  if (!std::ifstream(file)) throw InputError(file + ": cannot be read");
  requireReadableFormat(file);
  RawModel raw = importModel(file, {params.import_seconds, params.import_gigabytes});
  if (raw.vertices.empty()) throw InputError(file + ": the model has no vertices");
  return raw;
}

/// The files of map.additions, in metres.
std::vector<Addition> readAdditions(const MapParameters& params,
                                    std::vector<std::string>* warnings) {
  std::vector<Addition> additions;
  for (const std::string& file : patternsOf(params.additions)) {
    RawModel raw = readFile(file, params);
    const double unit = raw.in_metres || raw.unit <= 0 ? 1 : raw.unit;
    const auto warn = [&](const std::string& text) {
      if (!text.empty()) warnings->emplace_back(file).append(": ").append(text);
    };
    warn(coarseness(raw, unit, file));
    if (endsTooEarly(file)) warn("the file ends too early. Was it cut off?");
    if (raw.triangles.empty() && raw.lines.empty()) warn("there is nothing to add in the file");
    for (Eigen::Vector3d& v : raw.vertices) v *= unit;
    additions.push_back({file, std::move(raw)});
  }
  return additions;
}

/// @param model box around the model in the map frame, m. @param origin of the map frame
/// @throws InputError when an addition lies so far from the model that it has another unit or
/// belongs to another one.
void requireNear(const Addition& addition, const Eigen::AlignedBox3f& model,
                 const Eigen::Vector3d& origin) {
  // A yard is larger than its building, and millimetres are larger than metres by 1000.
  constexpr double kFar = 100, kTimes = 10;  // m, and sizes of the model
  const double most = std::max(kFar, kTimes * static_cast<double>(model.diagonal().norm()));
  for (const Eigen::Vector3d& v : addition.model.vertices) {
    if (!v.allFinite()) throw InputError(addition.file + ": a coordinate is not a number");
    const Eigen::Vector3d at = v - origin;
    if (model.cast<double>().exteriorDistance(at) > most)
      throw InputError(addition.file + ": " + metresText(v) +
                       " is far from the model. What map.additions adds must have the coordinates "
                       "of the model after scale and transform, in metres");
  }
}

Eigen::AlignedBox3f boxOf(const MeshSoup& soup) {
  Eigen::AlignedBox3f box;
  for (const Eigen::Vector3f& v : soup.vertices)
    if (v.allFinite()) box.extend(v);
  return box;
}

}  // namespace

MeshModel loadMesh(const std::string& file, const MapParameters& params) {
  RawModel raw = readFile(file, params);
  std::vector<std::string> of_additions;
  std::vector<Addition> additions = readAdditions(params, &of_additions);
  chooseObjects(params, file, &raw, &additions);
  std::map<std::string, size_t> objects;
  const auto count = [&](const RawModel& part) {
    for (const uint32_t i : part.triangle_object) ++objects[part.objects[i]];
    for (const uint32_t i : part.line_object) ++objects[part.objects[i]];
  };
  count(raw);
  for (const Addition& addition : additions) count(addition.model);
  dropUnusedVertices(&raw);
  // Metres per unit of the vertices. map.scale is metres per unit of the file.
  const double file_unit = raw.unit > 0 ? raw.unit : 1;
  const double of_file = params.scale > 0 ? params.scale : file_unit;
  const double scale = raw.in_metres ? of_file / file_unit : of_file;
  const std::string coarse = coarseness(raw, scale, file);
  const FileUnit unit{raw.unit, raw.unit_name, raw.in_metres};
  const int up_axis = raw.up_axis;
  const size_t empty_faces = raw.empty_faces;
  Eigen::Vector3d origin;
  MeshSoup soup = soupOf(std::move(raw), mapTransform(params, scale), params, &origin);
  const Eigen::AlignedBox3f box = boxOf(soup);
  for (Addition& addition : additions) {
    RawModel& added = addition.model;
    if (added.triangles.empty() && added.lines.empty()) continue;  // e.g. all are excluded
    dropUnusedVertices(&added);
    requireNear(addition, box, origin);
    append(std::move(added), origin, &soup);
  }
  const double tolerance = params.weld_tolerance > 0 ? params.weld_tolerance : weldTolerance(soup);
  MeshModel mesh = weldMesh(std::move(soup), tolerance, file);
  mesh.origin = origin;
  mesh.report.objects = std::move(objects);
  mesh.report.degenerate_triangles += empty_faces;
  std::vector<std::string>& warnings = mesh.report.warnings;
  if (!coarse.empty()) warnings.push_back(coarse);
  warnings.insert(warnings.end(), of_additions.begin(), of_additions.end());
  if (endsTooEarly(file))
    warnings.emplace_back(
        "the file ends too early. Was it cut off? Then a part of the model is missing");
  addUnit(unit, params.scale, &mesh.report);
  if (!origin.isZero()) warnings.push_back(originNote(origin));
  const double reach =
      static_cast<double>(mesh.lowest.cwiseAbs().cwiseMax(mesh.highest.cwiseAbs()).maxCoeff());
  constexpr double kFarFromOrigin = 8000;  // m, where single precision is good to 1 mm
  if (reach > kFarFromOrigin)
    warnings.push_back(
        "the model reaches " + std::to_string(std::lround(reach / 1000)) +
        " km from the map's origin, where coordinates are rounded to " +
        std::to_string(std::lround(1.2e-4 * reach)) +
        " mm. Is an object far away (map.exclude), or map.origin far from the model?");
  if (up_axis >= 0 && up_axis < 2)
    warnings.push_back(std::string("the file says that its ") + "xyz"[up_axis] + " axis is up. " +
                       (up_axis == 1 ? "map.roll_deg=90" : "map.pitch_deg=-90") +
                       " makes z the upward axis");
  addSizeWarnings(params.scale > 0 || of_file != 1, &mesh);
  return mesh;
}

}  // namespace edge_mcl
