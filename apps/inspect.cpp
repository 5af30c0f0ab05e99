// edge-mcl inspect: prints size, edges and faults of a model, so that the user sees whether the
// model is read as expected.
#include <CLI/CLI.hpp>
#include <array>
#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "apps/common_options.h"
#include "apps/output_files.h"
#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/drawing/overlay.h"
#include "edge_mcl/core/edges/model_hints.h"
#include "edge_mcl/core/image/picture_file.h"

namespace edge_mcl {

namespace {

struct InspectOptions {
  std::string model, picture;
  bool json = false, objects = false;
  ParameterOptions parameters;
};

std::vector<std::string> findings(const LocalizationMap& map) {
  std::vector<std::string> list = map.mesh().report.warnings;
  const MeshReport& r = map.mesh().report;
  if (r.flipped_pairs > 0)
    list.push_back(
        std::to_string(r.flipped_pairs) +
        " pairs of neighbouring faces have opposite winding (flipped normals); this does "
        "no harm here");
  if (r.boundary_edges > 0 && !map.mesh().triangles.empty())
    list.push_back(std::to_string(r.boundary_edges) +
                   " edges have only one face (holes, open sheets, or parts that are not welded); "
                   "with map.boundaries they are feature edges");
  if (r.covered_edges > 0) {
    std::array<char, 160> text{};
    std::snprintf(
        text.data(), text.size(),
        "%zu edges and pieces of others (%.4g m in all) are left out, because other faces "
        "cover them; map.seams keeps them",
        r.covered_edges, r.covered_length);
    list.emplace_back(text.data());
  }
  if (r.non_manifold_edges > 0)
    list.push_back(std::to_string(r.non_manifold_edges) + " edges have three or more faces");
  if (map.mesh().triangles.empty())
    list.push_back("the model has lines but no faces, so hidden lines cannot be removed");
  for (std::string& hint : modelHints(map.mesh(), map.edges())) list.push_back(std::move(hint));
  return list;
}

int run(const InspectOptions& o) {
  const Parameters params = o.parameters.load();
  checkPicture(o.picture);
  const LocalizationMap map(o.model, params);
  const MeshModel& mesh = map.mesh();
  const EdgeModel& edges = map.edges();
  if (!o.picture.empty()) writePicture(o.picture, drawWireframe(map, 1000, 800));
  const Eigen::Vector3f size = mesh.highest - mesh.lowest;
  if (o.json) {
    nlohmann::json j = {{"model", o.model},
                        {"vertices", mesh.vertices.size()},
                        {"triangles", mesh.triangles.size()},
                        {"materials", mesh.material_count},
                        {"lowest", {mesh.lowest.x(), mesh.lowest.y(), mesh.lowest.z()}},
                        {"highest", {mesh.highest.x(), mesh.highest.y(), mesh.highest.z()}},
                        {"samples", edges.sample_along.size()},
                        {"sample_step", edges.sample_step},
                        {"origin", {mesh.origin.x(), mesh.origin.y(), mesh.origin.z()}},
                        {"unit", mesh.report.unit},
                        {"warnings", findings(map)}};
    if (o.objects) j["objects"] = mesh.report.objects;
    for (int k = 0; k < kEdgeKinds; ++k)
      j["edges"][edgeKindName(static_cast<EdgeKind>(k))] = edges.countOf(static_cast<EdgeKind>(k));
    std::printf("%s\n", textOf(j).c_str());
    return kExitOk;
  }
  std::printf("%s\n", o.model.c_str());
  std::printf("  size       %.4g x %.4g x %.4g m, from (%.4g, %.4g, %.4g) to (%.4g, %.4g, %.4g)\n",
              size.x(), size.y(), size.z(), mesh.lowest.x(), mesh.lowest.y(), mesh.lowest.z(),
              mesh.highest.x(), mesh.highest.y(), mesh.highest.z());
  if (!mesh.report.unit.empty())
    std::printf("  unit       %s, as the file says\n", mesh.report.unit.c_str());
  if (!mesh.origin.isZero())
    std::printf("  origin     (%.12g, %.12g, %.12g) m in the file's coordinates\n", mesh.origin.x(),
                mesh.origin.y(), mesh.origin.z());
  std::printf(
      "  geometry   %zu vertices (%zu read), %zu triangles, %zu line elements, %u materials\n",
      mesh.vertices.size(), mesh.report.vertices_read, mesh.triangles.size(), mesh.lines.size(),
      mesh.material_count);
  std::printf("  edges     ");
  for (int k = 0; k < kEdgeKinds; ++k)
    std::printf(" %zu %s%s", edges.countOf(static_cast<EdgeKind>(k)),
                edgeKindName(static_cast<EdgeKind>(k)), k + 1 < kEdgeKinds ? "," : "");
  std::printf("; %zu collinear pieces are merged into other edges\n", edges.merged_pieces);
  std::printf("  samples    %zu, one every %.4g m; the feature edges have a length of %.4g m\n",
              edges.sample_along.size(), edges.sample_step, edges.feature_length);
  std::printf("  visibility cells with a side of %.3g m, occlusion tolerance %.3g mm\n",
              map.visibility().cellSize(), 1000 * map.visibility().occlusionTolerance());
  for (const std::string& f : findings(map)) std::printf("  note: %s\n", f.c_str());
  if (!o.picture.empty()) std::printf("  picture    %s\n", o.picture.c_str());
  if (o.objects)
    for (const auto& [name, parts] : mesh.report.objects)
      std::printf("  object     %s (%zu triangles and lines)\n", name.c_str(), parts);
  return kExitOk;
}

}  // namespace

void addInspect(CLI::App* app, Action* action) {
  auto o = std::make_shared<InspectOptions>();
  CLI::App* c = app->add_subcommand(
      "inspect", "print size, edges and warnings of a model, and draw its edges");
  c->add_option("model", o->model, "model file (OBJ, PLY, STL, DAE, glTF, IFC, ...)")->required();
  c->add_option("--picture", o->picture,
                "file for a picture of the model's edges, coloured by kind; default: no picture");
  c->add_flag("--objects", o->objects,
              "list the names of the model's objects, for map.include and map.exclude");
  c->add_flag("--json", o->json, "print the result as JSON; default: as text");
  o->parameters.addTo(c);
  c->callback([o, action] { *action = [o] { return run(*o); }; });
}

}  // namespace edge_mcl
