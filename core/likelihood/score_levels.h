/// Score of one sample, and the scores as bytes for the table of an image.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "edge_mcl/core/base/parameters.h"

namespace edge_mcl {

/// Score of one sample as a function of its distance d to the image edge.
///  - paper model: g(d) of equation (1). It is 0 where no edge is in reach.
///  - robust model: log-ratio r(d) of "a model edge is here" to "no model edge is here"
///    (docs/likelihood.md), log(e + (1 - e) p1(d) / p0(d)), minus its mean under p0. p1 is
///    half-normal. p0 is exponential with the image's own local density of edges of this direction.
///    Because of the mean, a pose that matches no better than chance scores 0, like a pose that
///    sees nothing of the model.
/// @param distance pixels, infinity when there is no edge.
/// @param clutter edges per pixel along the normal.
/// @param search_length pixels.
double sampleScore(const LikelihoodParameters& params, double distance, double clutter,
                   double search_length);

/// Mean of the log-ratio r under p0: the mean that chance gives.
/// @param clutter edges per pixel along the normal.
/// @param search_length pixels.
double meanLogRatioByChance(const LikelihoodParameters& params, double clutter,
                            double search_length);

/// Limits a measured density of edges to the range that the model can use. An empty image does not
/// tell its clutter. A full image has at most an edge every few pixels.
double usableClutter(double density);

/// Scores of every direction bin, distance and density of clutter as bytes 1..255, linear between
/// the lowest and the highest score. They are the same for all images.
class ScoreLevels {
 public:
  /// @param centred true: scores as sampleScore() gives. False (robust model): the mean by chance
  ///   is not subtracted, so that model edges without an image edge speak against a pose.
  ScoreLevels(const ImageParameters& image, const LikelihoodParameters& params,
              bool centred = true);

  /// Bytes by number of steps (EdgeField::steps()): entries() of them, in memory of at least 32.
  const uint8_t* codes(int bin, float clutter) const {
    return code_[static_cast<size_t>(bin) * levels_ + (levels_ == 1 ? 0 : levelOf(clutter))].data();
  }
  size_t entries() const { return entries_; }
  size_t levels() const { return levels_; }
  const uint8_t* codesOfLevel(int bin, size_t level) const {
    return code_[static_cast<size_t>(bin) * levels_ + level].data();
  }
  /// Densities of clutter at the borders between neighbouring levels.
  const std::vector<float>& borders() const { return borders_; }
  /// score = offset + scale * byte.
  float scale() const { return scale_; }
  float offset() const { return offset_; }

 private:
  size_t levelOf(float clutter) const;
  size_t levels_, entries_ = 0;
  float scale_ = 1, offset_ = 0;
  std::vector<std::array<uint8_t, 256>> code_;  // by (bin, level), then by number of steps
  std::vector<float> borders_;
};

}  // namespace edge_mcl
