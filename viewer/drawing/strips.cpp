// Draws the strips at the bottom of the window: curves over the last seconds.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <opencv2/imgproc.hpp>

#include "edge_mcl/viewer/drawing/panel_text.h"
#include "edge_mcl/viewer/drawing/panels.h"
#include "edge_mcl/viewer/drawing/view_colors.h"

namespace edge_mcl {

using namespace view_colors;

namespace {

/// Horizontal axis: time in s; the newest time is at the right.
struct TimeAxis {
  double now, seconds;
  int left, right;
  int at(double time) const {
    return right - static_cast<int>(std::lround((now - time) / seconds * (right - left)));
  }
};

/// Rounds up to 1, 2 or 5 times a power of ten.
double niceTop(double value) {
  const double power = std::pow(10, std::floor(std::log10(std::max(value, 1e-9))));
  for (double step : {1.0, 2.0, 5.0})
    if (value <= step * power) return step * power;
  return 10 * power;
}

/// Draws the frame of a strip. Name and present value stand left of it, the largest value of the
/// axis at its top.
void drawFrame(cv::Mat* panel, const cv::Rect& area, const std::string& name,
               const std::string& value, double top) {
  cv::rectangle(*panel, area, kPale, 1);
  panel_text::put(panel, name, {8, area.y + 13}, kInk);
  panel_text::put(panel, value, {8, area.y + 28}, kGrey);
  char text[24];
  std::snprintf(text, sizeof text, "%.3g", top);
  panel_text::put(panel, text, {area.x - panel_text::widthOf(text) - 4, area.y + 11}, kGrey);
}

using Value = std::function<std::optional<double>(const HistoryEntry&)>;

void drawCurve(cv::Mat* panel, const cv::Rect& area, const TimeAxis& axis,
               const HistoryView& history, double top, const cv::Scalar& color,
               const Value& value) {
  std::optional<cv::Point> last;
  for (const HistoryEntry& e : history.strip) {
    const std::optional<double> v = value(e);
    if (!v || !std::isfinite(*v)) {
      last.reset();
      continue;
    }
    const double share = std::min(1.0, *v / top);
    const cv::Point p(
        axis.at(e.time),
        area.y + area.height - 1 - static_cast<int>(std::lround(share * (area.height - 2))));
    cv::line(*panel, last.value_or(p), p, color, 2, cv::LINE_AA);
    last = p;
  }
}

double largest(const HistoryView& history, double at_least, const Value& value) {
  double top = at_least;
  for (const HistoryEntry& e : history.strip)
    if (const auto v = value(e); v && std::isfinite(*v)) top = std::max(top, *v);
  return niceTop(top);
}

void drawTimes(cv::Mat* panel, const cv::Rect& area, const TimeAxis& axis,
               const HistoryView& history, const UpdateTimes& now) {
  // The axis ends a little above the 90 % quantile. Rare long updates are cut off, like a search or
  // the first update.
  std::vector<double> totals;
  for (const HistoryEntry& e : history.strip) totals.push_back(e.times.total);
  double usual = 10;
  if (!totals.empty()) {
    const auto most =
        totals.begin() + static_cast<long>(0.9 * static_cast<double>(totals.size() - 1));
    std::nth_element(totals.begin(), most, totals.end());
    usual = std::max(usual, 1.2 * *most);
  }
  const double top = niceTop(usual);
  char value[32];
  std::snprintf(value, sizeof value, "%.1f ms", now.total);
  drawFrame(panel, area, "update", value, top);
  const cv::Scalar colors[UpdateTimes::kStages] = {kSkyBlue, kBlue, kOrange, kGreen, kPurple};
  int last_x = area.x;
  for (const HistoryEntry& e : history.strip) {
    const int x = axis.at(e.time);
    constexpr int kWidest = 12;
    const int width = std::clamp(x - last_x, 1, kWidest);
    last_x = x;
    double below = 0;
    for (size_t s = 0; s < UpdateTimes::kStages; ++s) {
      const auto y = [&](double ms) {
        return area.y + area.height - 1 -
               static_cast<int>(std::min(1.0, ms / top) * (area.height - 2));
      };
      const int from = y(below), to = y(below + e.times.stage[s]);
      if (from > to && x >= area.x)
        cv::rectangle(*panel, cv::Rect(std::max(area.x, x - width), to, width, from - to),
                      colors[s], cv::FILLED);
      below += e.times.stage[s];
    }
  }
  int x = area.x + 6;
  for (size_t s = 0; s < UpdateTimes::kStages; ++s) {
    cv::rectangle(*panel, {x, area.y + 4, 8, 8}, colors[s], cv::FILLED);
    x += 12 + panel_text::put(panel, UpdateTimes::name(s), {x + 12, area.y + 12}, kInk) + 8;
  }
}

}  // namespace

cv::Mat drawStrips(const ViewMoment& m, const HistoryView& history, double seconds,
                   const cv::Size& size) {
  cv::Mat panel(size, CV_8UC3, kPaper);
  // The axis is only as long as the history.
  const double span = history.strip.empty() ? seconds : m.time - history.strip.front().time;
  const TimeAxis axis{m.time, std::clamp(1.05 * span, 2.0, seconds), 150, size.width - 12};

  char text[160];
  std::snprintf(text, sizeof text, "t = %.2f s", m.elapsed);
  panel_text::put(&panel, text, {8, 16}, kInk);
  int x = 150;
  const std::string state = nameOf(m.state);
  panel_text::label(&panel, state, {x, 16}, ofState(m.state));
  x += panel_text::widthOf(state) + 16;
  std::snprintf(text, sizeof text, "%zu particles   match %.2f", m.particle_count, m.match_ratio);
  x += panel_text::put(&panel, text, {x, 16}, kInk) + 16;
  panel_text::put(&panel, m.problem, {x, 16}, kVermillion);

  constexpr int kTop = 26, kState = 10, kGap = 6, kFoot = 16;
  const int each = (size.height - kTop - kState - kFoot - 4 * kGap) / 3;
  for (size_t i = 0; i < history.strip.size(); ++i) {
    const HistoryEntry& e = history.strip[i];
    const double until = i + 1 < history.strip.size() ? history.strip[i + 1].time : m.time;
    const int from = std::max(axis.left, axis.at(e.time));
    cv::rectangle(panel, cv::Rect(from, kTop, std::max(1, axis.at(until) - from), kState),
                  ofState(e.state), cv::FILLED);
  }
  panel_text::put(&panel, "state", {8, kTop + 10}, kInk);

  const auto strip = [&](int k) {
    return cv::Rect(axis.left, kTop + kState + kGap + k * (each + kGap), axis.right - axis.left,
                    each);
  };
  const bool knows_truth = std::any_of(history.strip.begin(), history.strip.end(),
                                       [](const HistoryEntry& e) { return e.truth.has_value(); });
  const Value error = [&](const HistoryEntry& e) -> std::optional<double> {
    if (knows_truth) return e.error_position;
    return e.position ? std::optional<double>(e.std_position) : std::nullopt;
  };
  const double error_top = largest(history, 0.02, error);
  const std::optional<double> now =
      history.strip.empty() ? std::nullopt : error(history.strip.back());
  std::snprintf(text, sizeof text, now ? "%.1f cm" : "-", 100 * now.value_or(0));
  drawFrame(&panel, strip(0), knows_truth ? "error [m]" : "std. dev. [m]", text, error_top);
  drawCurve(&panel, strip(0), axis, history, error_top, kOrange, error);

  const Value ess = [](const HistoryEntry& e) { return e.effective_sample_size; };
  const double ess_top = largest(history, 10, ess);
  std::snprintf(text, sizeof text, "%.0f", m.effective_sample_size);
  drawFrame(&panel, strip(1), "ESS", text, ess_top);
  drawCurve(&panel, strip(1), axis, history, ess_top, kBlue, ess);

  drawTimes(&panel, strip(2), axis, history, m.times);
  std::snprintf(text, sizeof text, "%.3g s ago", axis.seconds);
  panel_text::put(&panel, text, {axis.left, size.height - 4}, kGrey);
  panel_text::put(&panel, "now", {axis.right - 26, size.height - 4}, kGrey);
  return panel;
}

}  // namespace edge_mcl
