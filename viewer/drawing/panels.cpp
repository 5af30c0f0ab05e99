#include "edge_mcl/viewer/drawing/panels.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <opencv2/imgproc.hpp>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/drawing/overlay.h"
#include "edge_mcl/core/image/pixel_scale.h"
#include "edge_mcl/viewer/drawing/panel_text.h"
#include "edge_mcl/viewer/drawing/view_colors.h"

namespace edge_mcl {

using namespace view_colors;

cv::Vec3b view_colors::ofWeight(float weight) {
  static const cv::Mat table = [] {
    cv::Mat ramp(1, 256, CV_8U), colors;
    for (int i = 0; i < 256; ++i) ramp.at<uint8_t>(i) = static_cast<uint8_t>(i);
    cv::applyColorMap(ramp, colors, cv::COLORMAP_VIRIDIS);
    return colors;
  }();
  // The scale spans three powers of ten, because most weights are very small after an update.
  const float shown = 1 + std::log10(std::max(1e-9F, weight)) / 3;
  const float clamped = std::min(1.0F, std::max(0.0F, shown));
  return table.at<cv::Vec3b>(static_cast<int>(clamped * 255));
}

PanelFit fitImage(const cv::Size& image, const cv::Size& panel) {
  PanelFit fit;
  if (image.empty() || panel.empty()) return fit;
  fit.scale = std::min(static_cast<double>(panel.width) / image.width,
                       static_cast<double>(panel.height) / image.height);
  const int width = std::min(panel.width, cvRound(image.width * fit.scale));
  const int height = std::min(panel.height, cvRound(image.height * fit.scale));
  fit.area = {(panel.width - width) / 2, (panel.height - height) / 2, width, height};
  return fit;
}

namespace {

/// Returns a dark panel with the picture in the area of the fit. The picture is resized when its
/// size differs from the area's, by a pixel of rounding.
cv::Mat framed(const cv::Mat& picture, const PanelFit& fit, const cv::Size& size) {
  cv::Mat panel(size, CV_8UC3, kDark);
  if (picture.size() == fit.area.size())
    picture.copyTo(panel(fit.area));
  else
    cv::resize(picture, panel(fit.area), fit.area.size());
  return panel;
}

cv::Mat asColor(const cv::Mat& image) {
  cv::Mat color = shownImage(image);
  if (color.channels() == 1) cv::cvtColor(color, color, cv::COLOR_GRAY2BGR);
  return color;
}

cv::Mat emptyPanel(const cv::Size& size, const std::string& title, const std::string& text) {
  cv::Mat panel(size, CV_8UC3, kDark);
  panel_text::title(&panel, {{title, kPaper}});
  panel_text::put(&panel, text, {size.width / 2 - 40, size.height / 2}, kGrey);
  return panel;
}

/// Returns the colour of a class. It depends on the name only, so it is the same in all images.
cv::Scalar colorOf(const std::string& name) {
  const cv::Scalar colors[] = {kPurple, kOrange, kSkyBlue, kGreen, kYellow, kVermillion};
  return colors[std::hash<std::string>()(name) % 6];
}

void tint(const cv::Mat& where, const cv::Scalar& color, cv::Mat* picture) {
  cv::Mat tinted;
  cv::addWeighted(*picture, 0.45, cv::Mat(picture->size(), CV_8UC3, color), 0.55, 0, tinted);
  tinted.copyTo(*picture, where);
}

}  // namespace

cv::Mat drawEdgePanel(const ViewMoment& m, const LocalizationMap* map, const ViewParameters& params,
                      const cv::Size& size) {
  if (m.image.empty()) return emptyPanel(size, "camera", "no image");
  const PanelFit fit = fitImage(m.image.size(), size);
  const bool fits_camera =
      m.has_camera && m.camera.width == m.image.cols && m.camera.height == m.image.rows;
  if (map == nullptr || !fits_camera) {
    cv::Mat panel = framed(asColor(m.image), fit, size);
    panel_text::title(&panel, {{"camera", kPaper}});
    return panel;
  }
  OverlayParts parts{params.model_edges, params.image_edges, params.normals, params.mask};
  if (!m.has_pose) parts.model_edges = parts.normals = false;
  cv::Mat picture;
  try {
    std::shared_ptr<const PreparedImage> prepared = m.prepared;
    if (!prepared) {
      // The panel draws only edges, so distances and scores are not computed.
      auto edges_only = std::make_shared<PreparedImage>();
      edges_only->edges = findEdges(
          m.image, m.mask,
          scaledBy(pixelScale(map->params().image, m.image.size()), map->params().image), "image");
      edges_only->frame.camera = m.camera;
      prepared = edges_only;
    }
    picture = drawOverlay(*map, *prepared, m.estimate.mean * m.T_base_camera, parts, fit.scale);
  } catch (const Error&) {
    picture = asColor(m.image);  // the localizer reports what is wrong with the image
  }
  cv::Mat panel = framed(picture, fit, size);
  std::vector<panel_text::Piece> pieces;
  if (parts.model_edges) pieces.push_back({"model edges", {90, 230, 60}});
  if (parts.image_edges) pieces.push_back({"image edges", {255, 160, 90}});
  if (parts.normals) pieces.push_back({"normals", {110, 110, 255}});
  if (pieces.empty()) pieces.push_back({"camera", kPaper});
  panel_text::title(&panel, pieces);
  return panel;
}

cv::Mat drawMaskPanel(const ViewMoment& m, const cv::Size& size) {
  if (m.image.empty()) return emptyPanel(size, "masks", "no image");
  const PanelFit fit = fitImage(m.image.size(), size);
  cv::Mat picture;
  cv::resize(asColor(m.image), picture, fit.area.size());
  cv::Mat mask;
  if (m.mask.size() == m.image.size() && m.mask.type() == CV_8U)
    cv::resize(m.mask, mask, fit.area.size(), 0, 0, cv::INTER_NEAREST);
  const auto inPicture = [&](const cv::Rect2f& box) {
    const auto s = static_cast<float>(fit.scale);
    const cv::Rect scaled(cvRound(box.x * s), cvRound(box.y * s), cvRound(box.width * s),
                          cvRound(box.height * s));
    return scaled & cv::Rect({0, 0}, picture.size());
  };
  if (!mask.empty()) {
    cv::Mat rest = mask.clone();
    for (const ShownObject& object : m.objects) {
      const cv::Rect box = inPicture(object.box);
      if (box.empty()) continue;
      cv::Mat part = picture(box);
      tint(rest(box), colorOf(object.name), &part);
      rest(box).setTo(0);
    }
    tint(rest, kPurple, &picture);
    std::vector<std::vector<cv::Point>> outlines;
    cv::findContours(mask, outlines, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_SIMPLE);
    cv::drawContours(picture, outlines, -1, kPaper, 1, cv::LINE_AA);
  }
  for (const ShownObject& object : m.objects) {
    const cv::Rect box = inPicture(object.box);
    if (box.empty()) continue;
    cv::rectangle(picture, box, colorOf(object.name), 2);
    char text[64];
    std::snprintf(text, sizeof text, "%.40s %.2f", object.name.c_str(),
                  static_cast<double>(object.score));
    // The label stays below the panel's title.
    panel_text::label(&picture, text, {box.x + 3, std::max(box.y + 14, 38)}, colorOf(object.name));
  }
  cv::Mat panel = framed(picture, fit, size);
  char share[48] = "masks: none received";
  if (!mask.empty())
    std::snprintf(share, sizeof share, "masked: %.0f %%",
                  100.0 * cv::countNonZero(mask) / static_cast<double>(mask.total()));
  panel_text::title(&panel, {{share, kPaper}});
  return panel;
}

cv::Mat drawLegend(const ViewMoment& m, const cv::Size& size) {
  cv::Mat panel(size, CV_8UC3, kPaper);
  int x = 10;
  const int y = size.height / 2;
  const auto entry = [&](const std::string& text, const cv::Scalar& color) {
    if (x > size.width - 60) return;
    cv::rectangle(panel, {x, y - 5, 12, 10}, color, cv::FILLED);
    x += 17 + panel_text::put(&panel, text, {x + 17, y + 5}, kInk) + 14;
  };
  entry("camera and path", kEstimate);
  if (m.truth) entry("ground truth", kTruth);
  entry("covariance, 3 sigma", kCovariance);
  if (!m.depth_points.empty()) entry("depth", kDepth);
  if (!m.clusters.empty()) entry("hypotheses", kHypothesis);
  if (!m.foreign.empty()) entry("not in the model", kForeign);
  if (!m.next_view.empty()) entry("next view", kNextView);
  if (m.weights.empty()) {  // the weights are unknown
    entry("particles", cv::Scalar(ofWeight(1)));
    return panel;
  }
  constexpr int kBar = 60;
  for (int i = 0; i < kBar && x + i < size.width; ++i) {
    const cv::Vec3b c = ofWeight(std::pow(10.0F, 3 * (static_cast<float>(i) / kBar - 1)));
    cv::line(panel, {x + i, y - 5}, {x + i, y + 4}, cv::Scalar(c));
  }
  panel_text::put(&panel, "particles, by weight", {x + kBar + 5, y + 5}, kInk);
  return panel;
}

}  // namespace edge_mcl
