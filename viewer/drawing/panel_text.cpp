#include "edge_mcl/viewer/drawing/panel_text.h"

#include <opencv2/imgproc.hpp>

namespace edge_mcl::panel_text {

namespace {
constexpr double kSize = 0.45;
constexpr int kFont = cv::FONT_HERSHEY_SIMPLEX;
}  // namespace

int widthOf(const std::string& text) {
  int base = 0;
  return cv::getTextSize(text, kFont, kSize, 1, &base).width;
}

int put(cv::Mat* panel, const std::string& text, cv::Point at, const cv::Scalar& color) {
  cv::putText(*panel, text, at, kFont, kSize, color, 1, cv::LINE_AA);
  return widthOf(text);
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
