#include "edge_mcl/core/score_table.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

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
      words_(static_cast<size_t>(bins_) * width_ * height_) {
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

  tbb::parallel_for(0, bins_, [&](int b) {
    std::vector<std::array<uint8_t, 256>> code(levels);
    for (int level = 0; level < levels; ++level)
      for (int s = 0; s <= field.noEdge(b); ++s)
        code[level][s] =
            static_cast<uint8_t>(1 + std::lround((scoreOf(b, s, level) - lowest) / scale));
    const auto codeAt = [&](int x, int y) {
      return code[levels == 1 ? 0 : levelOfDensity(field.clutter(b, x, y))].data();
    };
    constexpr int kCell = EdgeField::kClutterCell;
    std::vector<const uint8_t*> code_of_cell((width_ + kCell - 1) / kCell);
    std::vector<uint8_t> upper(width_ + 1), lower(width_ + 1);
    const auto fill = [&](int y, std::vector<uint8_t>* row) {
      if (y % kCell == 0)
        for (size_t c = 0; c < code_of_cell.size(); ++c)
          code_of_cell[c] = codeAt(static_cast<int>(c) * kCell, y);
      const uint8_t* steps = field.steps(b) + static_cast<size_t>(y) * width_;
      for (int x = 0; x < width_; ++x) (*row)[x] = code_of_cell[x / kCell][steps[x]];
      (*row)[width_] = (*row)[width_ - 1];
      if (!field.ignore().empty()) {
        const uint8_t* ignored = field.ignore().ptr<uint8_t>(y);
        for (int x = 0; x < width_; ++x)
          if (ignored[x]) (*row)[x] = 0;
      }
    };
    fill(0, &upper);
    for (int y = 0; y < height_; ++y) {
      if (y + 1 < height_)
        fill(y + 1, &lower);
      else
        lower = upper;
      uint32_t* out = &words_[(static_cast<size_t>(b) * height_ + y) * width_];
      const uint8_t *u = upper.data(), *l = lower.data();
      for (int x = 0; x < width_; ++x)
        out[x] = static_cast<uint32_t>(u[x]) | static_cast<uint32_t>(u[x + 1]) << 8 |
                 static_cast<uint32_t>(l[x]) << 16 | static_cast<uint32_t>(l[x + 1]) << 24;
      if (!field.ignore().empty())
        for (int x = 0; x < width_; ++x)
          if (!u[x] || !u[x + 1] || !l[x] || !l[x + 1]) out[x] = 0;
      std::swap(upper, lower);
    }
  });
}

}  // namespace edge_mcl
