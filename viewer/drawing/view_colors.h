/// Defines the colours of the viewer (blue, green, red). They are Okabe and Ito's palette, which
/// colour-blind readers can tell apart.
#pragma once

#include <opencv2/core.hpp>

#include "edge_mcl/localization/tracking/live_localizer.h"

namespace edge_mcl::view_colors {

inline const cv::Scalar kOrange(0, 159, 230), kSkyBlue(233, 180, 86), kGreen(115, 158, 0),
    kYellow(66, 228, 240), kBlue(178, 114, 0), kVermillion(0, 94, 213), kPurple(167, 121, 204),
    kInk(50, 50, 50), kGrey(150, 150, 150), kPale(225, 225, 225), kPaper(250, 250, 250),
    kDark(40, 40, 40);

inline const cv::Scalar &kEstimate = kOrange, &kTruth = kBlue, &kCovariance = kPurple,
                        &kDepth = kSkyBlue, &kHypothesis = kVermillion, &kNextView = kYellow,
                        &kForeign = kGreen;

/// Colour of a state of the localizer.
inline cv::Scalar ofState(LocalizerState state) {
  switch (state) {
    case LocalizerState::kTracking:
      return kGreen;
    case LocalizerState::kConverging:
      return kSkyBlue;
    case LocalizerState::kDegraded:
      return kOrange;
    case LocalizerState::kLost:
      return kVermillion;
    case LocalizerState::kSearching:
      return kPurple;
    case LocalizerState::kUninitialized:
      return kGrey;
  }
  return kGrey;
}

/// Colour of a particle: matplotlib's viridis, from dark for a small weight to bright for a large
/// one. The scale is logarithmic and ends at 1/1000. @param weight relative to the largest, 0 to 1.
cv::Vec3b ofWeight(float weight);

}  // namespace edge_mcl::view_colors
