#include "apps/recordings/align_points.h"

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "apps/common_options.h"
#include "apps/output_files.h"
#include "apps/recordings/placement.h"
#include "edge_mcl/core/base/angles.h"
#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/recordings/point_fit.h"

namespace edge_mcl {

namespace {

std::vector<PointPair> readPairs(const std::string& file) {
  std::ifstream in(file);
  if (!in) throw InputError(file + ": cannot be read");
  std::vector<PointPair> pairs;
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    line = line.substr(0, line.find('#'));
    std::replace_if(
        line.begin(), line.end(), [](char c) { return c == ',' || c == ';'; }, ' ');
    std::istringstream fields(line);
    PointPair pair;
    std::string more;
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    for (Eigen::Vector3d* point : {&pair.from, &pair.to})
      for (int k = 0; k < 3; ++k) fields >> (*point)[k];
    if (!fields || fields >> more)
      throw InputError(
          file + ":" + std::to_string(number) +
          ": six numbers are needed, x y z in the model and X Y Z in the other system");
    pairs.push_back(pair);
  }
  return pairs;
}

/// A point that is much farther off than the others was clicked at the wrong place. Without more
/// points than a similarity needs, none can be told from the others.
std::optional<size_t> wrongPoint(const PointFit& fit) {
  constexpr size_t kFewest = 4;
  constexpr double kFar = 0.1, kTimes = 3;  // m, times the median of the others
  std::vector<double> sorted = fit.residuals;
  std::sort(sorted.begin(), sorted.end());
  const double worst = sorted.back();
  if (sorted.size() < kFewest || worst < kFar || worst < kTimes * sorted[(sorted.size() - 1) / 2])
    return std::nullopt;
  return std::max_element(fit.residuals.begin(), fit.residuals.end()) - fit.residuals.begin();
}

void print(const Placement& placement, const PointFit& fit) {
  std::fputs(yamlOf(placement).c_str(), stdout);
  for (size_t i = 0; i < fit.residuals.size(); ++i)
    std::printf("point %zu is off by %.3f m\n", i + 1, fit.residuals[i]);
  std::printf("standard deviation: %.1f cm in the middle of the points, %.3f deg, scale %.2g\n",
              100 * fit.position_sigma, fit.rotation_sigma / kDegree, fit.scale_sigma);
  std::fputs(transformLine(placement, 1).c_str(), stdout);
}

nlohmann::json jsonOf(const Placement& placement, const PointFit& fit) {
  const MapParameters& m = placement.map;
  return {{"scale", m.scale},
          {"position", {m.x, m.y, m.z}},
          {"yaw_deg", m.yaw_deg},
          {"pitch_deg", m.pitch_deg},
          {"roll_deg", m.roll_deg},
          {"sigma",
           {{"position_m", fit.position_sigma},
            {"angle_deg", fit.rotation_sigma / kDegree},
            {"scale", fit.scale_sigma}}},
          {"residuals_m", fit.residuals}};
}

}  // namespace

int alignPoints(const std::string& file, const MapParameters& params, bool keep_scale,
                const std::string& out, bool json) {
  std::optional<double> scale;
  if (keep_scale) scale = params.scale > 0 ? params.scale : 1;
  PointFit fit;
  try {
    fit = fitPoints(readPairs(file), scale);
  } catch (const InputError& e) {
    const std::string why = e.what();
    throw InputError(why.rfind(file, 0) == 0 ? why : file + ": " + why);
  }
  // The points are those of the file, so no parameter has moved them.
  const Placement placement = placementOf(MapParameters(), 1, fit.similarity);
  if (!out.empty()) writeText(out, yamlOf(placement));
  if (json)
    std::printf("%s\n", textOf(jsonOf(placement, fit)).c_str());
  else
    print(placement, fit);
  const std::optional<size_t> wrong = wrongPoint(fit);
  if (wrong)
    std::fprintf(stderr, "warning: point %zu is off by %.2f m; is it the same place in both?\n",
                 *wrong + 1, fit.residuals[*wrong]);
  return wrong ? kExitIncomplete : kExitOk;
}

}  // namespace edge_mcl
