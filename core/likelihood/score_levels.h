/// Score of one sample, and its values as bytes for the per-image table.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "edge_mcl/core/base/parameters.h"

namespace edge_mcl {

/// Score of one sample as a function of its distance d to the image edge.
///  - paper model: g(d) of equation (1); 0 where no edge is in reach.
///  - robust model: log-ratio r(d) of "a model edge is here" to "none is", docs/likelihood.md:
///    log(e + (1 - e) p1(d) / p0(d)), p1 half-normal, p0 exponential with the image's own local
///    density of edges of this direction; minus its mean under p0, so that a pose that matches no
///    better than chance scores 0, like one that sees nothing of the model.
/// @param distance pixels, infinity for none. @param clutter edges per pixel along the normal.
double sampleScore(const LikelihoodParameters& params, double distance, double clutter,
                   double search_length);

/// Mean of the uncentred log-ratio under p0: what chance would give.
double meanLogRatioByChance(const LikelihoodParameters& params, double clutter,
                            double search_length);

/// Keeps a measured density of edges in the range that the model can use: an empty image knows
/// nothing of its clutter, a full one has at most an edge every few pixels.
double usableClutter(double density);

/// Scores of every direction bin, distance and density of clutter as bytes 1..255, linear between
/// the lowest and the highest score. The same for all images.
class ScoreLevels {
 public:
  /// @param centred as sampleScore; otherwise the mean by chance is not subtracted (robust model):
  /// then model edges that a bare image does not show speak against a pose.
  ScoreLevels(const ImageParameters& image, const LikelihoodParameters& params,
              bool centred = true);

  /// Bytes by number of steps (EdgeField::steps), entries() of them, in memory of at least 32.
  const uint8_t* codes(int bin, float clutter) const {
    return code_[static_cast<size_t>(bin) * levels_ + (levels_ == 1 ? 0 : levelOf(clutter))].data();
  }
  size_t entries() const { return entries_; }
  size_t levels() const { return levels_; }
  const uint8_t* codesOfLevel(int bin, size_t level) const {
    return code_[static_cast<size_t>(bin) * levels_ + level].data();
  }
  /// Densities of clutter between one level and the next.
  const std::vector<float>& borders() const { return borders_; }
  /// score = offset + scale * byte.
  float scale() const { return scale_; }
  float offset() const { return offset_; }

 private:
  size_t levelOf(float clutter) const;
  size_t levels_, entries_ = 0;
  float scale_ = 1, offset_ = 0;
  std::vector<std::array<uint8_t, 256>> code_;  // (bin, level), then steps
  std::vector<float> borders_;
};

}  // namespace edge_mcl
