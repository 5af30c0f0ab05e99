#include "apps/recordings/align_points.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
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
  std::error_code ignored;
  if (!in || std::filesystem::is_directory(file, ignored))
    throw InputError(file + ": cannot be read as a list of points");
  std::vector<PointPair> pairs;
  std::string line;
  for (int number = 1; std::getline(in, line); ++number) {
    if (number == 1 && line.rfind("\xEF\xBB\xBF", 0) == 0) line.erase(0, 3);  // mark of UTF-8
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

/// The root mean square of a fit; infinite when it cannot be made.
double rmsOf(const std::vector<PointPair>& pairs, std::optional<double> scale) {
  try {
    return fitPoints(pairs, scale).rms;
  } catch (const InputError&) {
    return INFINITY;
  }
}

/// A fit that is so much better tells what is wrong.
constexpr double kMuchBetter = 3;

std::string textOf(double metres) {
  char text[40];
  std::snprintf(text, sizeof text, "%.3f m", metres);
  return text;
}

/// The point without which the others agree much better. It takes five: four points without one are
/// three, which nearly always agree.
std::string wrongPoint(const std::vector<PointPair>& pairs, std::optional<double> scale,
                       const PointFit& fit) {
  constexpr size_t kFewest = 5;
  size_t worst = 0;
  double best = INFINITY;
  for (size_t i = 0; pairs.size() >= kFewest && i < pairs.size(); ++i) {
    std::vector<PointPair> others = pairs;
    others.erase(others.begin() + static_cast<long>(i));
    const double rms = rmsOf(others, scale);
    if (rms >= best) continue;
    best = rms;
    worst = i;
  }
  if (!(kMuchBetter * best < fit.rms)) return "";
  return "without point " + std::to_string(worst + 1) + " the others agree to " + textOf(best) +
         "; is it the same place in both?";
}

/// What is wrong with a fit, for a warning. Empty: nothing is.
std::string doubtOf(const std::vector<PointPair>& pairs, std::optional<double> scale,
                    const PointFit& fit) {
  // Clicks are right to some centimetres in rooms of metres, or to some pixels of a plan.
  constexpr double kPoor = 0.02, kTurned = 3 * kDegree, kGood = 0.03;  // of the extent; rad; m
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const PointPair& pair : pairs) middle += pair.to / static_cast<double>(pairs.size());
  double extent = 0;
  for (const PointPair& pair : pairs) extent = std::max(extent, (pair.to - middle).norm());
  constexpr char kDown[] =
      "the model comes out upside down; has one of the systems y down, or left-handed axes?";
  const bool is_down = fit.similarity.rotation(2, 2) < 0;
  if (fit.rms < kGood) return is_down ? kDown : "";
  std::vector<PointPair> mirrored = pairs;
  for (PointPair& pair : mirrored) pair.from.x() = -pair.from.x();
  const double as_mirrored = rmsOf(mirrored, scale), scaled = scale ? rmsOf(pairs, {}) : INFINITY;
  if (kMuchBetter * as_mirrored < fit.rms)
    return "the points agree to " + textOf(as_mirrored) +
           " when an axis of the model is mirrored (map.mirror)";
  if (is_down) return kDown;
  if (kMuchBetter * scaled < fit.rms)
    return "the points agree to " + textOf(scaled) + " when the scale is fitted, too";
  std::string wrong = wrongPoint(pairs, scale, fit);
  if (!wrong.empty()) return wrong;
  if (fit.rms < kPoor * extent && fit.rotation_sigma < kTurned) return "";
  return "the points agree to " + textOf(fit.rms) + " only; is each the same place in both?";
}

void print(const Placement& placement, const PointFit& fit) {
  std::fputs(yamlOf(placement).c_str(), stdout);
  for (size_t i = 0; i < fit.residuals.size(); ++i)
    std::printf("point %zu is off by %.3f m\n", i + 1, fit.residuals[i]);
  std::printf("standard deviation: %.1f cm in the middle of the points, %.3f deg, scale %.2g\n",
              100 * fit.position_sigma, fit.rotation_sigma / kDegree, fit.scale_sigma);
  std::fputs(transformLine(placement, 1).c_str(), stdout);
}

}  // namespace

int alignPoints(const std::string& file, const MapParameters& params, bool keep_scale,
                const std::string& out, bool json) {
  std::optional<double> scale;
  if (keep_scale) scale = params.scale > 0 ? params.scale : 1;
  const std::vector<PointPair> pairs = readPairs(file);
  PointFit fit;
  try {
    fit = fitPoints(pairs, scale);
  } catch (const InputError& e) {
    throw InputError(file + ": " + e.what());
  }
  // The points are those of the file, so no parameter has moved them.
  const Placement placement = placementOf(MapParameters(), 1, fit.similarity);
  if (!out.empty()) writeText(out, yamlOf(placement));
  if (json) {
    nlohmann::json result =
        jsonOf(placement, fit.position_sigma, fit.rotation_sigma, fit.scale_sigma);
    result["residuals_m"] = fit.residuals;
    std::printf("%s\n", textOf(result).c_str());
  } else {
    print(placement, fit);
  }
  const std::string doubt = doubtOf(pairs, scale, fit);
  if (!doubt.empty()) std::fprintf(stderr, "warning: %s: %s\n", file.c_str(), doubt.c_str());
  return doubt.empty() ? kExitOk : kExitIncomplete;
}

}  // namespace edge_mcl
