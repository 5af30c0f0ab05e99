#include "edge_mcl/core/score_table.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace edge_mcl {

double sampleScore(const LikelihoodParameters& params, double distance, double clutter) {
  const double gaussian =
      std::isinf(distance) ? 0
                           : std::exp(-distance * distance / (2 * params.sigma * params.sigma));
  if (params.model == LikelihoodModel::kPaper) return gaussian;
  const double e = params.missing_edge;
  if (gaussian == 0) return std::log(e);
  const double with_edge = 2 * gaussian / (std::sqrt(2 * M_PI) * params.sigma);
  const double without = 2 * clutter * std::exp(-2 * clutter * distance);
  return std::log(e + (1 - e) * with_edge / without);
}

double clutterDensity(double empty_share, double search_length) {
  // An empty image knows nothing of its clutter, a full one has at most an edge every few pixels.
  constexpr double kLeast = 0.004, kMost = 0.15;
  const double share = std::clamp(empty_share, 1e-9, 1.0);
  return std::clamp(-std::log(share) / (2 * search_length), kLeast, kMost);
}

ScoreTable::ScoreTable(const EdgeField& field, const LikelihoodParameters& params)
    : width_(field.width()),
      height_(field.height()),
      bins_(field.bins()),
      words_(static_cast<size_t>(bins_) * width_ * height_) {
  std::vector<std::array<double, 256>> scores(bins_);
  double lowest = std::numeric_limits<double>::infinity(), highest = -lowest;
  for (int b = 0; b < bins_; ++b) {
    const double clutter = clutterDensity(field.emptyShare(b), field.searchLength());
    for (int s = 0; s <= field.noEdge(b); ++s) {
      const double d = s == field.noEdge(b) ? std::numeric_limits<double>::infinity()
                                            : s * field.stepLength(b);
      scores[b][s] = sampleScore(params, d, clutter);
      lowest = std::min(lowest, scores[b][s]);
      highest = std::max(highest, scores[b][s]);
    }
  }
  if (highest <= lowest) highest = lowest + 1;
  const double scale = (highest - lowest) / 254;
  scale_ = static_cast<float>(scale);
  offset_ = static_cast<float>(lowest - scale);

  tbb::parallel_for(0, bins_, [&](int b) {
    std::array<uint8_t, 256> code{};
    for (int s = 0; s <= field.noEdge(b); ++s)
      code[s] = static_cast<uint8_t>(1 + std::lround((scores[b][s] - lowest) / scale));
    std::vector<uint8_t> upper(width_ + 1), lower(width_ + 1);
    const auto fill = [&](int y, std::vector<uint8_t>* row) {
      const uint8_t* steps = field.steps(b) + static_cast<size_t>(y) * width_;
      for (int x = 0; x < width_; ++x) (*row)[x] = code[steps[x]];
      (*row)[width_] = (*row)[width_ - 1];
      if (!field.ignore().empty()) {
        const uint8_t* ignored = field.ignore().ptr<uint8_t>(y);
        for (int x = 0; x < width_; ++x)
          if (ignored[x]) (*row)[x] = 0;
      }
    };
    const bool masked = !field.ignore().empty();
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
      if (masked)
        for (int x = 0; x < width_; ++x)
          if (!u[x] || !u[x + 1] || !l[x] || !l[x + 1]) out[x] = 0;
      std::swap(upper, lower);
    }
  });
}

}  // namespace edge_mcl
