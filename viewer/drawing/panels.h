/// Draws the flat parts of the viewer's window as pictures (CV_8UC3, blue green red).
#pragma once

#include <opencv2/core.hpp>

#include "edge_mcl/viewer/drawing/view_parameters.h"
#include "edge_mcl/viewer/moments/view_history.h"
#include "edge_mcl/viewer/moments/view_moment.h"

namespace edge_mcl {

/// Place of an image in a panel.
struct PanelFit {
  double scale = 1;  ///< panel pixels per image pixel
  cv::Rect area;     ///< pixels of the panel
};
/// Fits an image into the middle of a panel, as large as its proportions allow.
PanelFit fitImage(const cv::Size& image, const cv::Size& panel);

/// Draws the camera image with model edges, image edges, normals and mask, as in the paper's figure
/// 1. Model edges and normals need a pose. Without a map, or without the calibration of the image,
/// the panel shows the image alone. @param map may be null. @param size of the panel, pixels.
cv::Mat drawEdgePanel(const ViewMoment& moment, const LocalizationMap* map,
                      const ViewParameters& params, const cv::Size& size);

/// Draws the camera image with masked pixels tinted. Detected objects have a box, their class name
/// and their score.
cv::Mat drawMaskPanel(const ViewMoment& moment, const cv::Size& size);

/// Draws state, position error (standard deviation without ground truth), effective sample size and
/// times over the last seconds. @param seconds longest time span of the strips.
cv::Mat drawStrips(const ViewMoment& moment, const HistoryView& history, double seconds,
                   const cv::Size& size);

/// Draws the meaning of the colours in the 3D scene.
cv::Mat drawLegend(const ViewMoment& moment, const cv::Size& size);

}  // namespace edge_mcl
