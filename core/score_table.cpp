#include "edge_mcl/core/score_table.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

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
  constexpr int kSteps = 400;  // Simpson's rule
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
/// Densities are rounded to these many levels, evenly on a logarithmic scale.
constexpr int kLevels = 24;

double densityOfLevel(int level) {
  return kLeastClutter *
         std::pow(kMostClutter / kLeastClutter, static_cast<double>(level) / (kLevels - 1));
}

int levelOfDensity(double density) {
  const double position =
      std::log(usableClutter(density) / kLeastClutter) / std::log(kMostClutter / kLeastClutter);
  return static_cast<int>(std::lround(position * (kLevels - 1)));
}

}  // namespace

double usableClutter(double density) { return std::clamp(density, kLeastClutter, kMostClutter); }

ScoreTable::ScoreTable(const EdgeField& field, const LikelihoodParameters& params)
    : width_(field.width()),
      height_(field.height()),
      bins_(field.bins()),
      has_ignored_(!field.ignore().empty()),
      // One more element: the kernels read two neighbours at once, beyond the last column too.
      pairs_(static_cast<size_t>(bins_) * rows() * stride() + 1) {
  // In the paper's model clutter plays no part.
  const int levels = params.model == LikelihoodModel::kPaper ? 1 : kLevels;
  std::vector<double> score_of(static_cast<size_t>(bins_) * levels * 256);
  const auto scoreOf = [&](int bin, int steps, int level) -> double& {
    return score_of[(static_cast<size_t>(bin) * levels + level) * 256 + steps];
  };
  double lowest = std::numeric_limits<double>::infinity(), highest = -lowest;
  for (int level = 0; level < levels; ++level) {
    const double density = densityOfLevel(level);
    const double by_chance = params.model == LikelihoodModel::kPaper
                                 ? 0
                                 : meanLogRatioByChance(params, density, field.searchLength());
    for (int b = 0; b < bins_; ++b)
      for (int s = 0; s <= field.noEdge(b); ++s) {
        const double d = s == field.noEdge(b) ? std::numeric_limits<double>::infinity()
                                              : s * field.stepLength(b);
        double& score = scoreOf(b, s, level);
        score = params.model == LikelihoodModel::kPaper
                    ? sampleScore(params, d, density, field.searchLength())
                    : logRatio(params, d, density) - by_chance;
        lowest = std::min(lowest, score);
        highest = std::max(highest, score);
      }
  }
  if (highest <= lowest) highest = lowest + 1;
  const double scale = (highest - lowest) / 254;
  scale_ = static_cast<float>(scale);
  offset_ = static_cast<float>(lowest - scale);

  LargeBuffer<uint8_t> codes(static_cast<size_t>(bins_) * rows() * stride());
  const size_t plane = static_cast<size_t>(rows()) * stride();
  pairs_[bins_ * plane] = 0;
  tbb::parallel_for(0, bins_, [&](int b) {
    std::vector<std::array<uint8_t, 256>> code(levels);
    for (int level = 0; level < levels; ++level)
      for (int s = 0; s <= field.noEdge(b); ++s)
        code[level][s] =
            static_cast<uint8_t>(1 + std::lround((scoreOf(b, s, level) - lowest) / scale));
    constexpr int kCell = EdgeField::kClutterCell;
    std::vector<const uint8_t*> code_of_cell((width_ + kCell - 1) / kCell);
    for (int y = 0; y < height_; ++y) {
      if (y % kCell == 0)
        for (size_t c = 0; c < code_of_cell.size(); ++c)
          code_of_cell[c] =
              code[levels == 1 ? 0
                               : levelOfDensity(field.clutter(b, static_cast<int>(c) * kCell, y))]
                  .data();
      uint8_t* row = &codes[b * plane + static_cast<size_t>(y) * stride()];
      const uint8_t* steps = field.steps(b) + static_cast<size_t>(y) * width_;
      for (int x = 0; x < width_; ++x) row[x] = code_of_cell[x / kCell][steps[x]];
      if (has_ignored_) {
        const uint8_t* ignored = field.ignore().ptr<uint8_t>(y);
        for (int x = 0; x < width_; ++x)
          if (ignored[x]) row[x] = 0;
      }
      row[width_] = row[width_ - 1];
    }
    const uint8_t* last = &codes[b * plane + static_cast<size_t>(height_ - 1) * stride()];
    std::copy(last, last + stride(), &codes[b * plane + static_cast<size_t>(height_) * stride()]);
  });
  tbb::parallel_for(0, bins_, [&](int b) {
    const uint8_t *here = &codes[b * plane], *next = &codes[(b + 1) % bins_ * plane];
    uint16_t* out = &pairs_[b * plane];
    for (size_t i = 0; i < plane; ++i) out[i] = static_cast<uint16_t>(here[i] | next[i] << 8);
  });
}

}  // namespace edge_mcl
