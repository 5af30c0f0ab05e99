/// The flat parts of the window, as pictures.
#pragma once

#include <opencv2/core.hpp>

#include "edge_mcl/viewer/drawing/view_parameters.h"
#include "edge_mcl/viewer/moments/view_history.h"
#include "edge_mcl/viewer/moments/view_moment.h"

namespace edge_mcl {

/// Where an image lies in a panel that it fills as far as its proportions let it.
struct PanelFit {
  double scale = 1;
  cv::Rect area;
};
PanelFit fitImage(const cv::Size& image, const cv::Size& panel);

/// The image with the paper's figure 1 over it; without a pose or a map only the image.
/// @param map may be null.
cv::Mat drawEdgePanel(const ViewMoment& moment, const LocalizationMap* map,
                      const ViewParameters& params, const cv::Size& size);

/// The image with what is masked in colour, and named where that is known.
cv::Mat drawMaskPanel(const ViewMoment& moment, const cv::Size& size);

/// State, error (or standard deviation, where the truth is not known), effective sample size and
/// times over the last seconds.
cv::Mat drawStrips(const ViewMoment& moment, const HistoryView& history, double seconds,
                   const cv::Size& size);

/// What the colours in space mean.
cv::Mat drawLegend(const ViewMoment& moment, const cv::Size& size);

}  // namespace edge_mcl
