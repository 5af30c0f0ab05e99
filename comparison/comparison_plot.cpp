#include "edge_mcl/comparison/comparison_plot.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <opencv2/imgproc.hpp>

#include "edge_mcl/comparison/compared_methods.h"

namespace edge_mcl {

namespace {

constexpr int kWidth = 560, kHeight = 420, kLegendRow = 22;
const cv::Scalar kInk(60, 60, 60), kFaint(225, 225, 225);

void label(cv::Mat* picture, const std::string& text, cv::Point at, const cv::Scalar& colour,
           double size) {
  cv::putText(*picture, text, at, cv::FONT_HERSHEY_SIMPLEX, size, colour, 1, cv::LINE_AA);
}

/// Okabe and Ito's palette and grey; letters tell them apart as well.
cv::Scalar colourOf(size_t method) {
  static const cv::Scalar kColours[] = {{178, 114, 0}, {0, 94, 213},  {167, 121, 204},
                                        {115, 158, 0}, {0, 159, 230}, {233, 180, 86},
                                        {0, 0, 0},     {40, 40, 150}, {150, 150, 150}};
  return kColours[method % 9];
}

std::string letterOf(size_t method) { return std::string(1, static_cast<char>('A' + method)); }

size_t indexOf(const std::string& method) {
  const auto& all = comparedMethods();
  return static_cast<size_t>(
      std::find_if(all.begin(), all.end(), [&](const auto& m) { return m.name == method; }) -
      all.begin());
}

struct Axis {
  bool logarithmic = false;
  double low = 1e18, high = -1e18;
  void include(double v) {
    if (logarithmic) v = std::log10(std::max(v, 1e-4));
    low = std::min(low, v);
    high = std::max(high, v);
  }
  void close() {
    if (low > high) low = high = 0;
    if (logarithmic) {
      low = std::floor(low);
      high = std::max(std::ceil(high), low + 1);
    } else {
      high = std::max(high, low + 1e-3);
    }
  }
  double at(double v) const {
    return ((logarithmic ? std::log10(std::max(v, 1e-4)) : v) - low) / (high - low);
  }
  std::vector<double> ticks() const {
    std::vector<double> values;
    if (logarithmic)
      for (double e = low; e <= high + 0.5; ++e) values.push_back(std::pow(10, e));
    else
      for (int k = 0; k <= 4; ++k) values.push_back(low + k * (high - low) / 4);
    return values;
  }
};

class Chart {
 public:
  Chart(cv::Mat* picture, cv::Point corner, const Axis& x, const Axis& y)
      : picture_(picture),
        inner_(corner.x + 64, corner.y + 34, kWidth - 90, kHeight - 84),
        x_(x),
        y_(y) {}
  void drawFrame(const std::string& title, const std::string& x_label,
                 const std::string& y_label) const {
    label(picture_, title, {inner_.x, inner_.y - 12}, kInk, 0.55);
    for (double v : x_.ticks()) {
      const int px = at(v, 1).x;
      cv::line(*picture_, {px, inner_.y}, {px, inner_.br().y}, kFaint);
      label(picture_, number(v), {px - 12, inner_.br().y + 18}, kInk, 0.42);
    }
    for (double v : y_.ticks()) {
      const int py = at(1, v).y;
      cv::line(*picture_, {inner_.x, py}, {inner_.br().x, py}, kFaint);
      label(picture_, number(v), {inner_.x - 46, py + 4}, kInk, 0.42);
    }
    cv::rectangle(*picture_, inner_, cv::Scalar(150, 150, 150), 1);
    label(picture_, x_label, {inner_.x + inner_.width / 2 - 80, inner_.br().y + 38}, kInk, 0.45);
    label(picture_, y_label, {inner_.x + 6, inner_.y + 16}, kInk, 0.45);
  }
  cv::Point at(double x, double y) const {
    return {inner_.x + static_cast<int>(std::lround(x_.at(x) * inner_.width)),
            inner_.br().y - static_cast<int>(std::lround(y_.at(y) * inner_.height))};
  }
  void curve(const std::vector<cv::Point>& points, const cv::Scalar& colour, int width) const {
    cv::polylines(*picture_, points, false, colour, width, cv::LINE_AA);
  }
  void mark(cv::Point p, size_t method) const {
    cv::circle(*picture_, p, 5, colourOf(method), cv::FILLED, cv::LINE_AA);
    label(picture_, letterOf(method), p + cv::Point(7, -4), colourOf(method), 0.45);
  }

 private:
  static std::string number(double v) {
    char text[32];
    std::snprintf(text, sizeof text, "%.4g", v);
    return text;
  }
  cv::Mat* picture_;
  cv::Rect inner_;
  Axis x_, y_;
};

template <class Item>
std::vector<std::string> sequencesOf(const std::vector<Item>& items) {
  std::vector<std::string> names;
  for (const Item& item : items)
    if (std::find(names.begin(), names.end(), item.sequence) == names.end())
      names.push_back(item.sequence);
  return names;
}

/// White, with the legend at the bottom; panels in two columns.
cv::Mat emptyPicture(size_t panels) {
  const auto& methods = comparedMethods();
  const int rows = std::max(1, static_cast<int>((panels + 1) / 2));
  const int legend = kLegendRow * static_cast<int>((methods.size() + 1) / 2) + 20;
  cv::Mat picture(rows * kHeight + legend, 2 * kWidth, CV_8UC3, cv::Scalar::all(255));
  for (size_t i = 0; i < methods.size(); ++i) {
    const cv::Point at(60 + static_cast<int>(i % 2) * kWidth,
                       rows * kHeight + 20 + kLegendRow * static_cast<int>(i / 2));
    cv::circle(picture, at - cv::Point(12, 4), 5, colourOf(i), cv::FILLED, cv::LINE_AA);
    label(&picture, letterOf(i) + "  " + methods[i].title, at, colourOf(i), 0.5);
  }
  return picture;
}

cv::Point cornerOf(size_t panel) {
  return {static_cast<int>(panel % 2) * kWidth, static_cast<int>(panel / 2) * kHeight};
}

}  // namespace

cv::Mat drawAccuracy(const std::vector<ComparedRow>& rows) {
  const std::vector<std::string> sequences = sequencesOf(rows);
  cv::Mat picture = emptyPicture(sequences.size());
  for (size_t s = 0; s < sequences.size(); ++s) {
    Axis x{true}, y{true};
    for (const ComparedRow& r : rows) {
      if (r.sequence != sequences[s] || r.failed == r.runs) continue;
      if (r.particles > 0) x.include(r.update_ms);
      y.include(100 * r.position);
    }
    x.close();
    y.close();
    const Chart chart(&picture, cornerOf(s), x, y);
    chart.drawFrame(sequences[s], "ms per update, one core", "position error, cm (median)");
    for (size_t m = 0; m < comparedMethods().size(); ++m) {
      std::vector<const ComparedRow*> of_method;
      for (const ComparedRow& r : rows)
        if (r.sequence == sequences[s] && indexOf(r.method) == m && r.failed < r.runs)
          of_method.push_back(&r);
      std::sort(of_method.begin(), of_method.end(),
                [](const auto* a, const auto* b) { return a->particles < b->particles; });
      std::vector<cv::Point> points;
      for (const ComparedRow* r : of_method)
        points.push_back(chart.at(r->particles > 0 ? r->update_ms : 0, 100 * r->position));
      // Dead reckoning costs nothing: a line at its error.
      if (!of_method.empty() && of_method.front()->particles == 0)
        points.push_back(chart.at(1e9, 100 * of_method.front()->position));
      for (cv::Point& p : points) {
        const cv::Point low = chart.at(std::pow(10, x.low), 1);
        const cv::Point high = chart.at(std::pow(10, x.high), 1);
        p.x = std::clamp(p.x, low.x, high.x);
      }
      chart.curve(points, colourOf(m), 1);
      for (const cv::Point& p : points) chart.mark(p, m);
    }
  }
  return picture;
}

cv::Mat drawErrors(const std::vector<ComparedRun>& runs) {
  const std::vector<std::string> sequences = sequencesOf(runs);
  cv::Mat picture = emptyPicture(sequences.size());
  for (size_t s = 0; s < sequences.size(); ++s) {
    uint64_t first_seed = UINT64_MAX;
    Axis x, y{true};
    for (const ComparedRun& r : runs) {
      if (r.sequence != sequences[s]) continue;
      first_seed = std::min(first_seed, r.seed);
      for (double t : r.time) x.include(t);
      for (double e : r.position_series) y.include(std::max(0.1, 100 * e));
    }
    x.close();
    y.close();
    const Chart chart(&picture, cornerOf(s), x, y);
    chart.drawFrame(sequences[s], "s", "position error, cm");
    for (const ComparedRun& r : runs) {
      if (r.sequence != sequences[s] || r.seed != first_seed || r.time.empty()) continue;
      const size_t m = indexOf(r.method);
      std::vector<cv::Point> points;
      for (size_t i = 0; i < r.time.size() && i < r.position_series.size(); ++i)
        points.push_back(chart.at(r.time[i], std::max(0.1, 100 * r.position_series[i])));
      chart.curve(points, colourOf(m), 1);
      // Letters along the way, so that they do not all stand in one place.
      const size_t at = points.size() * (m + 1) / (comparedMethods().size() + 1);
      label(&picture, letterOf(m), points[at] + cv::Point(2, -4), colourOf(m), 0.45);
    }
  }
  return picture;
}

}  // namespace edge_mcl
