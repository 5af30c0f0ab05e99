#include "edge_mcl/core/likelihood/score_levels.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "edge_mcl/core/image/edge_field.h"

namespace edge_mcl {

namespace {

double logRatio(const LikelihoodParameters& params, double distance, double clutter) {
  const double e = params.missing_edge;
  if (std::isinf(distance)) return std::log(e);
  const double gaussian = std::exp(-distance * distance / (2 * params.sigma * params.sigma));
  const double with_edge = 2 * gaussian / (std::sqrt(2 * M_PI) * params.sigma);
  const double without = 2 * clutter * std::exp(-2 * clutter * distance);
  return std::log(e + (1 - e) * with_edge / without);
}

}  // namespace

double meanLogRatioByChance(const LikelihoodParameters& params, double clutter,
                            double search_length) {
  constexpr int kSteps = 400;  // of Simpson's rule
  const double h = search_length / kSteps;
  double sum = 0;
  for (int i = 0; i <= kSteps; ++i) {
    const double d = i * h, density = 2 * clutter * std::exp(-2 * clutter * d);
    const int factor = i == 0 || i == kSteps ? 1 : (i % 2 ? 4 : 2);
    sum += factor * density * logRatio(params, d, clutter);
  }
  const double none = std::exp(-2 * clutter * search_length);
  return sum * h / 3 + none * std::log(params.missing_edge);
}

double sampleScore(const LikelihoodParameters& params, double distance, double clutter,
                   double search_length) {
  if (params.model == LikelihoodModel::kPaper)
    return std::isinf(distance)
               ? 0
               : std::exp(-distance * distance / (2 * params.sigma * params.sigma));
  return logRatio(params, distance, clutter) - meanLogRatioByChance(params, clutter, search_length);
}

namespace {

constexpr double kLeastClutter = 0.004, kMostClutter = 0.15;
/// Number of levels to which densities are rounded. Levels are evenly spaced on a logarithmic
/// scale.
constexpr int kLevels = 24;

double densityOfLevel(double level) {
  return kLeastClutter * std::pow(kMostClutter / kLeastClutter, level / (kLevels - 1));
}

}  // namespace

double usableClutter(double density) { return std::clamp(density, kLeastClutter, kMostClutter); }

ScoreLevels::ScoreLevels(const ImageParameters& image, const LikelihoodParameters& params,
                         bool centred)
    // In the paper's model clutter has no effect.
    : levels_(params.model == LikelihoodModel::kPaper ? 1 : kLevels) {
  const SearchGeometry search(image);
  std::vector<std::array<double, 256>> score(search.bins() * levels_);
  double lowest = std::numeric_limits<double>::infinity(), highest = -lowest;
  for (size_t level = 0; level < levels_; ++level) {
    const double density = densityOfLevel(static_cast<double>(level));
    const double by_chance = params.model == LikelihoodModel::kPaper || !centred
                                 ? 0
                                 : meanLogRatioByChance(params, density, search.length());
    for (int b = 0; b < search.bins(); ++b) {
      entries_ = std::max(entries_, size_t{search.noEdge(b)} + 1);
      for (int s = 0; s <= search.noEdge(b); ++s) {
        const double d = s == search.noEdge(b) ? std::numeric_limits<double>::infinity()
                                               : s * search.stepLength(b);
        double& of_steps = score[b * levels_ + level][s];
        of_steps = params.model == LikelihoodModel::kPaper
                       ? sampleScore(params, d, density, search.length())
                       : logRatio(params, d, density) - by_chance;
        lowest = std::min(lowest, of_steps);
        highest = std::max(highest, of_steps);
      }
    }
    if (level > 0)
      borders_.push_back(static_cast<float>(densityOfLevel(static_cast<double>(level) - 0.5)));
  }
  if (highest <= lowest) highest = lowest + 1;
  const double scale = (highest - lowest) / 254;
  scale_ = static_cast<float>(scale);
  offset_ = static_cast<float>(lowest - scale);
  code_.resize(score.size());
  for (size_t row = 0; row < score.size(); ++row)
    for (int s = 0; s <= search.noEdge(static_cast<int>(row / levels_)); ++s)
      code_[row][s] = static_cast<uint8_t>(1 + std::lround((score[row][s] - lowest) / scale));
}

size_t ScoreLevels::levelOf(float clutter) const {
  return static_cast<size_t>(std::upper_bound(borders_.begin(), borders_.end(), clutter) -
                             borders_.begin());
}

}  // namespace edge_mcl
