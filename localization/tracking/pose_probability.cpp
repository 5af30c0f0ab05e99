#include "edge_mcl/localization/tracking/pose_probability.h"

#include <algorithm>
#include <cmath>

namespace edge_mcl {

namespace {

// Factors of the logistic regression: constant, of the logarithm of the contrast, of the logarithm
// of the number of lines.
constexpr double kConstant = -17.1, kOfContrast = 7.4, kOfLines = 0.64;
/// Depth images: log-odds per share of points on the model, and the share of even odds.
constexpr double kOfAgreement = 10, kEvenAgreement = 0.3;
/// One image is never more certain than this.
constexpr double kMostCertain = 8;

/// Images of one second see about the same, so they count together as one.
constexpr double kMemory = 1;  // s
constexpr double kLeastWeight = 0.15, kFirstWeight = 0.3;
/// The odds of a pose that was given: somebody meant it to be right. The odds of a pose that the
/// search has found: it reports none before several images leave no other.
constexpr double kGiven = 0.5, kProven = 3;
/// Lines in view from which an image has its full weight. A bare wall shows fewer.
constexpr double kManyLines = 10;
/// An image that contradicts the ones before counts at once, with this much benefit of the doubt.
constexpr double kBenefit = 2;
/// Measured log-odds of images together, by their mean: a constant and a factor.
constexpr double kOfNone = -0.8, kOfMean = 2;
/// Without images the odds are forgotten over this time.
constexpr double kForget = 3;  // s

}  // namespace

std::optional<ImageOdds> oddsOf(const UpdateReport& report) {
  if (!report.has_information) return std::nullopt;
  std::optional<double> odds;
  double weight = 1;
  if (report.visible_lines > 0) {
    odds = kConstant + kOfContrast * std::log(std::max(report.contrast, 0.1)) +
           kOfLines * std::log(std::max(report.visible_lines, 0.1));
    if (!(report.depth_points > 0)) weight = std::min(1.0, report.visible_lines / kManyLines);
  }
  if (report.depth_points > 0) {
    const double of_depth = kOfAgreement * (report.depth_agreement - kEvenAgreement);
    odds = std::min(odds.value_or(of_depth), of_depth);
  }
  if (!odds) return std::nullopt;
  return ImageOdds{std::clamp(*odds, -kMostCertain, kMostCertain), weight};
}

void PoseProbability::begin(bool proven) {
  mean_ = highest_ = proven ? kProven : kGiven;
  last_.reset();
}

void PoseProbability::add(double time, const ImageOdds& image) {
  const double passed = last_ ? std::max(0.0, time - *last_) : 0;
  const double weight =
      last_ ? std::max(kLeastWeight, 1 - std::exp(-passed / kMemory)) : kFirstWeight;
  mean_ += weight * image.weight * (image.log_odds - mean_);
  highest_ = image.log_odds + kBenefit / std::max(image.weight, 1e-3);
  last_ = time;
}

void PoseProbability::wait(double time) {
  const double passed = last_ ? std::max(0.0, time - *last_) : 0;
  mean_ *= std::exp(-passed / kForget);
  highest_ = mean_;
  last_ = time;
}

double PoseProbability::value() const {
  return 1 / (1 + std::exp(-kOfNone - kOfMean * std::min(mean_, highest_)));
}

}  // namespace edge_mcl
