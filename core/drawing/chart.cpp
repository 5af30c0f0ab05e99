#include "edge_mcl/core/drawing/chart.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <opencv2/imgproc.hpp>

#include "edge_mcl/core/drawing/text.h"

namespace edge_mcl {

namespace {

std::string numberText(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", value);
  return text;
}

/// The largest of 1, 2 and 5 times a power of ten that is not above the value.
double roundStep(double value) {
  const double power = std::pow(10, std::floor(std::log10(value)));
  const double rest = value / power;
  return (rest >= 5 ? 5 : rest >= 2 ? 2 : 1) * power;
}

}  // namespace

double ChartAxis::scaled(double value) const {
  constexpr double kLeast = 1e-4;  // a logarithmic axis has no zero
  return logarithmic_ ? std::log10(std::max(value, kLeast)) : value;
}

void ChartAxis::include(double value) {
  low_ = std::min(low_, scaled(value));
  high_ = std::max(high_, scaled(value));
}

void ChartAxis::close(double margin) {
  if (low_ > high_) low_ = high_ = 0;
  if (logarithmic_) {
    low_ = std::floor(low_);
    high_ = std::max(std::ceil(high_), low_ + 1);
  }
  setSpan(std::max(span(), 1e-3) * (1 + 2 * margin));
}

void ChartAxis::setSpan(double span) {
  const double middle = (low_ + high_) / 2;
  low_ = middle - span / 2;
  high_ = middle + span / 2;
}

double ChartAxis::at(double value) const { return (scaled(value) - low_) / span(); }

std::vector<double> ChartAxis::ticks() const {
  constexpr double kWanted = 5;    // ticks
  constexpr double kSlack = 1e-9;  // rounding
  std::vector<double> values;
  if (logarithmic_) {
    for (double e = std::ceil(low_ - kSlack); e <= high_ + kSlack; ++e)
      values.push_back(std::pow(10, e));
    return values;
  }
  const double step = roundStep(span() / kWanted * 1.5);
  for (double v = std::ceil(low_ / step - kSlack) * step; v <= high_ + kSlack * step; v += step)
    values.push_back(std::abs(v) < kSlack * step ? 0 : v);
  return values;
}

Chart::Chart(cv::Rect area, std::string title, ChartAxis x, ChartAxis y, bool equal_scale)
    : area_(area), title_(std::move(title)), x_(std::move(x)), y_(std::move(y)) {
  constexpr int kTop = 48, kBottom = 44, kRight = 26, kGap = 8;  // room for labels, pixels
  int widest = 0;
  for (const double v : y_.ticks())
    widest = std::max(widest, textSize(numberText(v), kChartText).width);
  const int left = widest + 2 * kGap;
  inner_ = {area.x + left, area.y + kTop, area.width - left - kRight, area.height - kTop - kBottom};
  if (!equal_scale) return;
  const double per_pixel = std::max(x_.span() / inner_.width, y_.span() / inner_.height);
  x_.setSpan(per_pixel * inner_.width);
  y_.setSpan(per_pixel * inner_.height);
}

cv::Point Chart::at(double x, double y) const {
  return {inner_.x + static_cast<int>(std::lround(x_.at(x) * inner_.width)),
          inner_.br().y - static_cast<int>(std::lround(y_.at(y) * inner_.height))};
}

void Chart::drawFrame(cv::Mat* picture) const {
  constexpr int kGap = 6;
  drawText(picture, title_, {inner_.x, area_.y + 20}, chartInk(), kChartTitle);
  drawText(picture, y_.label(), {inner_.x, inner_.y - kGap}, chartInk(), kChartText);
  int free_from = 0;  // a label that would touch the one before is left out
  for (const double v : x_.ticks()) {
    const int px = inner_.x + static_cast<int>(std::lround(x_.at(v) * inner_.width));
    cv::line(*picture, {px, inner_.y}, {px, inner_.br().y}, chartGrid());
    const std::string text = numberText(v);
    const int half = textSize(text, kChartText).width / 2;
    if (px - half < free_from) continue;
    drawText(picture, text, {px, inner_.br().y + kChartText + kGap}, chartInk(), kChartText,
             TextAnchor::kCentre);
    free_from = px + half + kGap;
  }
  for (const double v : y_.ticks()) {
    const int py = inner_.br().y - static_cast<int>(std::lround(y_.at(v) * inner_.height));
    cv::line(*picture, {inner_.x, py}, {inner_.br().x, py}, chartGrid());
    drawText(picture, numberText(v), {inner_.x - kGap, py + kChartText / 3}, chartInk(), kChartText,
             TextAnchor::kRight);
  }
  cv::rectangle(*picture, inner_, cv::Scalar(150, 150, 150), 1);
  drawText(picture, x_.label(), {inner_.x + inner_.width / 2, inner_.br().y + 2 * kChartText + 10},
           chartInk(), kChartText, TextAnchor::kCentre);
}

cv::Scalar seriesColour(size_t series) {
  // Blue, vermilion, bluish green, reddish purple, orange, sky blue, black, grey for yellow, which
  // is too pale on white. OpenCV's order: blue, green, red.
  static const cv::Scalar kColours[] = {{178, 114, 0},   {0, 94, 213},   {115, 158, 0},
                                        {167, 121, 204}, {0, 159, 230},  {233, 180, 86},
                                        {0, 0, 0},       {140, 140, 140}};
  return kColours[series % std::size(kColours)];
}

void drawMark(cv::Mat* picture, cv::Point centre, size_t series, const cv::Scalar& colour,
              int radius) {
  const int r = radius, x = centre.x, y = centre.y;
  const auto fill = [&](const std::vector<cv::Point>& corners) {
    cv::fillPoly(*picture, std::vector<std::vector<cv::Point>>{corners}, colour, cv::LINE_AA);
  };
  const auto marker = [&](cv::MarkerTypes type) {
    cv::drawMarker(*picture, centre, colour, type, 2 * r + 1, 2, cv::LINE_AA);
  };
  switch (series % 9) {
    case 0:
      return cv::circle(*picture, centre, r, colour, cv::FILLED, cv::LINE_AA);
    case 1:
      return fill({{x - r, y - r}, {x + r, y - r}, {x + r, y + r}, {x - r, y + r}});
    case 2:
      return fill({{x, y - r}, {x + r, y + r}, {x - r, y + r}});
    case 3:
      return fill({{x, y - r - 1}, {x + r + 1, y}, {x, y + r + 1}, {x - r - 1, y}});
    case 4:
      return marker(cv::MARKER_TILTED_CROSS);
    case 5:
      return marker(cv::MARKER_CROSS);
    case 6:
      return marker(cv::MARKER_STAR);
    case 7:
      return fill({{x - r, y - r}, {x + r, y - r}, {x, y + r}});
    default:
      return cv::circle(*picture, centre, r, colour, 2, cv::LINE_AA);
  }
}

}  // namespace edge_mcl
