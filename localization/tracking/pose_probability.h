/// Probability that the pose is right, from how the images contrast it with other poses.
#pragma once

#include <optional>

#include "edge_mcl/localization/filter/pose_filter.h"

namespace edge_mcl {

/// A pose is right when it is within this distance of the true pose, m and degrees.
constexpr double kRightWithin = 0.25, kRightWithinDeg = 5;

/// What one image tells.
struct ImageOdds {
  double log_odds = 0;  ///< natural logarithm of P(right) / P(wrong)
  double weight = 1;    ///< 0 to 1; an image with few lines tells little, whatever they say
};

/// Odds that one image gives to the pose. It compares the pose with poses turned away from it in
/// the same image (UpdateReport::contrast), so it needs no limit that depends on the building. The
/// factors come from a logistic regression, see docs/decisions/tracking-probability.md.
/// @param agreement share of a depth image that lies on the model, without what is in front of it
/// (ForeignPoints::agreement). Wrong poses that fit the lines by chance seldom fit the surfaces.
/// none: it is not known
/// @return none: the image told nothing
std::optional<ImageOdds> oddsOf(const UpdateReport& report,
                                std::optional<double> agreement = std::nullopt);

/// What an image tells where another pose looks alike.
/// @param log_odds of the pose against the other one, by the image. @param by_motion the same by
/// motion, see LookAlikeWatch::Result
ImageOdds amongLookAlikes(ImageOdds image, double log_odds, double by_motion);

/// Follows the probability from image to image: a hidden Markov model of two states, right and
/// wrong. Images that follow one another see about the same, so they count together as one.
class PoseProbability {
 public:
  /// Starts at a pose. @param proven the search has found it in several images
  void begin(bool proven);
  /// Adds an image. @param time s
  void add(double time, const ImageOdds& image);
  /// Adds a moment without a usable image: the odds fall back to even.
  void wait(double time);
  /// Probability that the pose is within kRightWithin and kRightWithinDeg, 0 to 1.
  double value() const;

 private:
  double odds_ = 0;                          // natural logarithm of P(right) / P(wrong)
  double highest_ = 0;                       // that the last image allows
  std::optional<double> last_, last_image_;  // s
};

}  // namespace edge_mcl
