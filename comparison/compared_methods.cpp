#include "edge_mcl/comparison/compared_methods.h"

#include <algorithm>

#include "edge_mcl/comparison/mrpt_filter_2d.h"
#include "edge_mcl/comparison/mrpt_filter_3d.h"
#include "edge_mcl/comparison/own_filters.h"
#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/import/mesh_loader.h"
#include "edge_mcl/mrpt_plugins/CEdgeMap.h"

namespace edge_mcl {

namespace {

// MRPT's likelihoods of points and rays must be adapted to the sensor. These values were the best
// of a trial on the office flight (docs/comparison.md).
constexpr double kPointSpacing = 0.05, kPointSigma = 0.005, kPower = 1;

std::vector<ComparedMethod> makeMethods() {
  using Settings = std::vector<std::pair<std::string, std::string>>;
  const auto own = [](const char* name, const char* title, bool depth, Settings settings) {
    ComparedMethod m;
    m.name = name;
    m.title = title;
    m.needs_depth = depth;
    m.settings = std::move(settings);
    return m;
  };
  std::vector<ComparedMethod> methods;
  methods.push_back(own("edges", "edge_mcl, edges", false, {}));
  methods.push_back(own("edges_paper", "edge_mcl, edges, the paper's likelihood", false,
                        {{"likelihood.model", "paper"}}));
  methods.push_back(own("edges_unmasked", "edge_mcl, edges, without masks", false, {}));
  methods.back().uses_masks = false;
  methods.back().needs_masks = true;
  methods.push_back(own("depth", "edge_mcl, depth", true, {{"likelihood.cues", "depth"}}));
  methods.push_back(own("both", "edge_mcl, edges and depth", true, {{"likelihood.cues", "both"}}));
  methods.push_back(own("edges_in_mrpt", "MRPT's 3D filter on edge_mcl's map", false, {}));
  methods.back().kind = MethodKind::kEdgesInMrptFilter;
  methods.push_back(own("mrpt_3d", "MRPT's 3D filter on a point map", true, {}));
  methods.back().kind = MethodKind::kPointMap;
  methods.push_back(own("mrpt_2d", "MRPT's 2D filter on a grid", true, {}));
  methods.back().kind = MethodKind::kFloorPlan;
  methods.push_back(own("dead_reckoning", "dead reckoning", false, {}));
  methods.back().kind = MethodKind::kDeadReckoning;
  return methods;
}

}  // namespace

bool ComparedMethod::fits(const Sequence& sequence) const {
  const bool has_masks =
      std::any_of(sequence.frames.begin(), sequence.frames.end(),
                  [](const SequenceFrame& frame) { return !frame.mask_file.empty(); });
  return (!needs_depth || !sequence.depths.empty()) && (!needs_masks || has_masks) &&
         (kind != MethodKind::kDeadReckoning || sequence.has_odometry);
}

const std::vector<ComparedMethod>& comparedMethods() {
  static const std::vector<ComparedMethod> methods = makeMethods();
  return methods;
}

const ComparedMethod& comparedMethod(const std::string& name) {
  std::string names;
  for (const ComparedMethod& m : comparedMethods()) {
    if (m.name == name) return m;
    names += (names.empty() ? "" : ", ") + m.name;
  }
  throw ParameterError("method " + name + ": one of " + names + " expected");
}

std::unique_ptr<ComparedFilter> makeFilter(const ComparedMethod& method, const Sequence& sequence,
                                           int particles, uint64_t seed) {
  Parameters params;
  for (const auto& [name, value] : method.settings) params.set(name, value);
  params.filter.particles = particles;
  params.filter.seed = seed;
  params.likelihood.backend = BackendChoice::kCpu;
  switch (method.kind) {
    case MethodKind::kOwn:
      return std::make_unique<OwnFilter>(
          std::make_shared<LocalizationMap>(sequence.model_file, params));
    case MethodKind::kEdgesInMrptFilter:
      return std::make_unique<MrptFilter3D>(std::make_shared<CEdgeMap>(sequence.model_file, params),
                                            observeImages(), params.filter, 1);
    case MethodKind::kPointMap:
      return std::make_unique<MrptFilter3D>(
          pointMapOf(loadMesh(sequence.model_file, params.map), kPointSpacing, kPointSigma),
          observePoints(params.depth), params.filter, kPower);
    case MethodKind::kFloorPlan:
      return std::make_unique<MrptFilter2D>(loadMesh(sequence.model_file, params.map),
                                            startOf(sequence).translation().z(), params.filter,
                                            params.depth, FloorPlanParameters(), kPower);
    case MethodKind::kDeadReckoning:
      return std::make_unique<DeadReckoning>(params.filter);
  }
  throw Error("unknown method");
}

}  // namespace edge_mcl
