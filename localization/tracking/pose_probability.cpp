#include "edge_mcl/localization/tracking/pose_probability.h"

#include <algorithm>
#include <cmath>

namespace edge_mcl {

namespace {

// Factors of the logistic regression: constant, and of the logarithm of the contrast. A contrast
// of 7.2 gives even odds.
constexpr double kConstant = -19.6, kOfContrast = 9.93;
/// Lines in view from which an image has its full weight. A bare wall shows fewer.
constexpr double kManyLines = 10;
/// The same where a depth image tells the share of it that lies on the model, with factors of this
/// share and of the share of kManyLines that is in view. A single wall fits many poses, and then
/// few lines are in view. A share outside the limits tells no more than the limit.
constexpr double kConstantWithDepth = -53.1, kOfContrastWithDepth = 6.93, kOfShare = 39.1,
                 kOfLines = 5.9;
constexpr double kLeastShare = 0.75, kMostShare = 0.98;
/// Depth lowers the log-odds by no more than this, since the model may be inexact. The limit falls
/// to 0 from kManyLines to kLinesEnough lines: in cluttered flights 15 % of the depth lay beside
/// the model at right poses, which had 50 to 80 lines.
constexpr double kMostAgainst = 2, kLinesEnough = 40;
/// Depth images as a cue: log-odds per share of points on the model, and the share of even odds.
constexpr double kOfAgreement = 10, kEvenAgreement = 0.3;
/// One image is never more certain than this.
constexpr double kMostCertain = 8;

/// Images of two seconds see about the same, so together they confirm the pose as one. Images of a
/// third of a second contradict it as one: a robot that was carried away must be noticed soon.
constexpr double kToConfirm = 2, kToContradict = 0.3;  // s
/// Weight of the first image, and the least weight of one whose stamp stands still.
constexpr double kFirstWeight = 0.5, kLeastWeight = 0.02;
/// A right pose becomes wrong, or a wrong one right, at this rate. It limits what is certain.
constexpr double kRateOfChange = 0.01;  // per s
/// A longer gap counts as one of this length.
constexpr double kLongestGap = 3;  // s
/// A pose that became right must be able to prove it soon.
constexpr double kLowest = -4;
/// The odds of a pose that was given are even. The odds of a pose that the search has found are
/// high: it reports none before several images leave no other.
constexpr double kGiven = 0, kProven = 3;
/// An image that contradicts the ones before counts at once, with this much benefit of the doubt.
constexpr double kBenefit = 1;
/// Without images the odds are forgotten over this time.
constexpr double kForget = 3;  // s

double probabilityOf(double log_odds) { return 1 / (1 + std::exp(-log_odds)); }

/// Two states, right and wrong, that change into one another.
double oddsAfter(double log_odds, double time) {
  const double changed = kRateOfChange * std::min(time, kLongestGap);
  const double right = probabilityOf(log_odds);
  const double later = right * (1 - changed) + (1 - right) * changed;
  return std::log(later / (1 - later));
}

}  // namespace

std::optional<ImageOdds> oddsOf(const UpdateReport& report, std::optional<double> agreement) {
  if (!report.has_information) return std::nullopt;
  std::optional<double> odds;
  double weight = 1;
  if (report.visible_lines > 0) {
    const double contrast = std::log(std::max(report.contrast, 0.1));
    const double lines = std::min(1.0, report.visible_lines / kManyLines);
    odds = kConstant + kOfContrast * contrast;
    if (agreement) {
      const double with_depth = kConstantWithDepth + kOfContrastWithDepth * contrast +
                                kOfShare * std::clamp(*agreement, kLeastShare, kMostShare) +
                                kOfLines * lines;
      const double more = (report.visible_lines - kManyLines) / (kLinesEnough - kManyLines);
      const double against = kMostAgainst * (1 - std::clamp(more, 0.0, 1.0));
      odds = std::max(with_depth, *odds - against);
    }
    if (!(report.depth_points > 0)) weight = lines;
  }
  if (report.depth_points > 0) {
    const double of_depth = kOfAgreement * (report.depth_agreement - kEvenAgreement);
    odds = std::min(odds.value_or(of_depth), of_depth);
  }
  if (!odds) return std::nullopt;
  return ImageOdds{std::clamp(*odds, -kMostCertain, kMostCertain), weight};
}

ImageOdds amongLookAlikes(ImageOdds image, double log_odds, double by_motion) {
  if (log_odds >= image.log_odds) return image;
  image.log_odds = log_odds;
  if (log_odds >= 0) return image;
  image.log_odds += by_motion;
  // The image does not tell which of the two it is, but motion does. The same motion must not count
  // in every image, so it builds no trust.
  if (image.log_odds >= 0) return {0, 0};
  return image;
}

void PoseProbability::begin(bool proven) {
  odds_ = highest_ = proven ? kProven : kGiven;
  last_.reset();
  last_image_.reset();
}

void PoseProbability::add(double time, const ImageOdds& image) {
  double weight = kFirstWeight;
  if (last_) odds_ = oddsAfter(odds_, std::max(0.0, time - *last_));
  if (last_image_) {
    const double passed = std::max(0.0, time - *last_image_);
    weight =
        std::clamp(passed / (image.log_odds > 0 ? kToConfirm : kToContradict), kLeastWeight, 1.0);
  }
  odds_ = std::max(kLowest, odds_ + weight * image.weight * image.log_odds);
  highest_ = image.log_odds + kBenefit / std::max(image.weight, 1e-3);
  last_ = last_image_ = time;
}

void PoseProbability::wait(double time) {
  const double passed = last_ ? std::max(0.0, time - *last_) : 0;
  odds_ *= std::exp(-passed / kForget);
  highest_ = odds_;
  last_ = time;
}

double PoseProbability::value() const { return probabilityOf(std::min(odds_, highest_)); }

}  // namespace edge_mcl
