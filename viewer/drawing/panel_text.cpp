#include "edge_mcl/viewer/drawing/panel_text.h"

#include <opencv2/imgproc.hpp>

#include "edge_mcl/core/drawing/text.h"

namespace edge_mcl::panel_text {

namespace {
constexpr int kHeight = 14;  // pixels
}  // namespace

int widthOf(const std::string& text) { return textSize(text, kHeight).width; }

int put(cv::Mat* panel, const std::string& text, cv::Point at, const cv::Scalar& color) {
  return drawText(panel, text, at, color, kHeight);
}

void label(cv::Mat* panel, const std::string& text, cv::Point at, const cv::Scalar& color) {
  cv::rectangle(*panel, {at.x - 3, at.y - 12, widthOf(text) + 6, 16}, color, cv::FILLED);
  put(panel, text, at, cv::Scalar(20, 20, 20));
}

void title(cv::Mat* panel, const std::vector<Piece>& pieces) {
  constexpr int kGap = 14;
  int width = kGap;
  for (const Piece& piece : pieces) width += widthOf(piece.text) + kGap;
  const cv::Rect ground = cv::Rect(0, 0, width, 22) & cv::Rect({0, 0}, panel->size());
  cv::Mat part = (*panel)(ground);
  part = part * 0.25;
  int x = kGap;
  for (const Piece& piece : pieces) x += put(panel, piece.text, {x, 16}, piece.color) + kGap;
}

}  // namespace edge_mcl::panel_text
