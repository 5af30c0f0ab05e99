#include "edge_mcl/localization/filter/resampling.h"

#include <algorithm>
#include <cmath>

namespace edge_mcl {

std::vector<double> normalize(const std::vector<double>& log_weights) {
  std::vector<double> weights(log_weights.size());
  const double highest = *std::max_element(log_weights.begin(), log_weights.end());
  if (!std::isfinite(highest)) {
    std::fill(weights.begin(), weights.end(), 1.0 / static_cast<double>(weights.size()));
    return weights;
  }
  double sum = 0;
  for (size_t i = 0; i < weights.size(); ++i)
    sum += weights[i] = std::exp(log_weights[i] - highest);
  for (double& w : weights) w /= sum;
  return weights;
}

double effectiveSampleSize(const std::vector<double>& weights) {
  double squares = 0;
  for (double w : weights) squares += w * w;
  return 1 / squares;
}

double temperingExponent(const std::vector<double>& fixed,
                         const std::vector<double>& log_likelihood, double floor_share) {
  const auto essAt = [&](double t) {
    std::vector<double> logs(fixed.size());
    for (size_t i = 0; i < logs.size(); ++i) logs[i] = fixed[i] + t * log_likelihood[i];
    return effectiveSampleSize(normalize(logs));
  };
  const double wanted = std::min(floor_share * static_cast<double>(fixed.size()), essAt(0));
  if (essAt(1) >= wanted) return 1;
  double low = 0, high = 1;
  for (int i = 0; i < 14; ++i) {  // bisection to 1e-4
    const double middle = (low + high) / 2;
    (essAt(middle) >= wanted ? low : high) = middle;
  }
  return low;
}

std::vector<uint32_t> systematicResample(const std::vector<double>& weights, int count,
                                         double offset) {
  std::vector<uint32_t> survivors;
  survivors.reserve(count);
  double cumulative = 0;
  size_t i = 0;
  for (int k = 0; k < count; ++k) {
    const double at = (k + offset) / count;
    while (i + 1 < weights.size() && cumulative + weights[i] <= at) cumulative += weights[i++];
    survivors.push_back(static_cast<uint32_t>(i));
  }
  return survivors;
}

}  // namespace edge_mcl
