#include "edge_mcl/comparison/comparison_plot.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "edge_mcl/comparison/compared_methods.h"
#include "edge_mcl/core/drawing/chart.h"
#include "edge_mcl/core/drawing/text.h"

namespace edge_mcl {

namespace {

constexpr int kWidth = 600, kHeight = 440;  // of a chart, pixels
constexpr int kLegendRow = 24, kLegendText = 14;

size_t indexOf(const std::string& method) {
  const auto& all = comparedMethods();
  return static_cast<size_t>(
      std::find_if(all.begin(), all.end(), [&](const auto& m) { return m.name == method; }) -
      all.begin());
}

template <class Item>
std::vector<std::string> sequencesOf(const std::vector<Item>& items) {
  std::vector<std::string> names;
  for (const Item& item : items)
    if (std::find(names.begin(), names.end(), item.sequence) == names.end())
      names.push_back(item.sequence);
  return names;
}

/// White, with room for charts in two columns and the legend at the bottom.
cv::Mat emptyPicture(size_t charts) {
  const auto& methods = comparedMethods();
  const int rows = std::max(1, static_cast<int>((charts + 1) / 2));
  const int legend = kLegendRow * static_cast<int>((methods.size() + 1) / 2) + 30;
  cv::Mat picture(rows * kHeight + legend, 2 * kWidth, CV_8UC3, cv::Scalar::all(255));
  for (size_t i = 0; i < methods.size(); ++i) {
    const cv::Point at(60 + static_cast<int>(i % 2) * kWidth,
                       rows * kHeight + 24 + kLegendRow * static_cast<int>(i / 2));
    const cv::Point centre = at - cv::Point(20, 5);
    cv::line(picture, centre - cv::Point(14, 0), centre + cv::Point(14, 0), seriesColour(i), 1,
             cv::LINE_AA);
    drawMark(&picture, centre, i, seriesColour(i));
    drawText(&picture, methods[i].title, at, chartInk(), kLegendText);
  }
  return picture;
}

cv::Rect areaOf(size_t chart) {
  return {static_cast<int>(chart % 2) * kWidth, static_cast<int>(chart / 2) * kHeight, kWidth,
          kHeight};
}

/// Rows of one method on one sequence, by number of particles. Failed ones are left out.
std::vector<const ComparedRow*> rowsOf(const std::vector<ComparedRow>& rows,
                                       const std::string& sequence, size_t method) {
  std::vector<const ComparedRow*> list;
  for (const ComparedRow& r : rows)
    if (r.sequence == sequence && indexOf(r.method) == method && r.failed < r.runs)
      list.push_back(&r);
  std::sort(list.begin(), list.end(),
            [](const auto* a, const auto* b) { return a->particles < b->particles; });
  return list;
}

}  // namespace

cv::Mat drawAccuracy(const std::vector<ComparedRow>& rows) {
  const std::vector<std::string> sequences = sequencesOf(rows);
  cv::Mat picture = emptyPicture(sequences.size());
  for (size_t s = 0; s < sequences.size(); ++s) {
    ChartAxis x("time per update on one core, ms", true);
    ChartAxis y("median position error, cm", true);
    for (const ComparedRow& r : rows) {
      if (r.sequence != sequences[s] || r.failed == r.runs) continue;
      if (r.particles > 0) x.include(r.update_ms);
      y.include(100 * r.position);
    }
    x.close();
    y.close();
    const Chart chart(areaOf(s), sequences[s], x, y);
    chart.drawFrame(&picture);
    for (size_t m = 0; m < comparedMethods().size(); ++m) {
      std::vector<cv::Point> points;
      for (const ComparedRow* r : rowsOf(rows, sequences[s], m)) {
        const cv::Point p = chart.at(r->update_ms, 100 * r->position);
        if (r->particles > 0) {
          points.push_back(p);
        } else {
          // Dead reckoning takes no time: its error is a line across the chart.
          points.emplace_back(chart.inner().x, p.y);
          points.emplace_back(chart.inner().br().x, p.y);
        }
      }
      cv::polylines(picture, points, false, seriesColour(m), 1, cv::LINE_AA);
      for (const cv::Point& p : points) drawMark(&picture, p, m, seriesColour(m));
    }
  }
  return picture;
}

cv::Mat drawErrors(const std::vector<ComparedRun>& runs) {
  constexpr double kLeast = 0.1;  // cm; smaller errors are drawn there
  constexpr size_t kMarks = 5;    // per curve
  const std::vector<std::string> sequences = sequencesOf(runs);
  cv::Mat picture = emptyPicture(sequences.size());
  for (size_t s = 0; s < sequences.size(); ++s) {
    uint64_t first_seed = UINT64_MAX;
    ChartAxis x("time, s"), y("position error, cm", true);
    for (const ComparedRun& r : runs) {
      if (r.sequence != sequences[s]) continue;
      first_seed = std::min(first_seed, r.seed);
      for (double t : r.time) x.include(t);
      for (double e : r.position_series) y.include(std::max(kLeast, 100 * e));
    }
    x.close();
    y.close();
    const Chart chart(areaOf(s), sequences[s], x, y);
    chart.drawFrame(&picture);
    for (const ComparedRun& r : runs) {
      if (r.sequence != sequences[s] || r.seed != first_seed || r.time.empty()) continue;
      const size_t m = indexOf(r.method), methods = comparedMethods().size();
      std::vector<cv::Point> points;
      for (size_t i = 0; i < r.time.size() && i < r.position_series.size(); ++i)
        points.push_back(chart.at(r.time[i], std::max(kLeast, 100 * r.position_series[i])));
      cv::polylines(picture, points, false, seriesColour(m), 1, cv::LINE_AA);
      // The marks of different methods stand at different times, so that they do not overlap.
      for (size_t k = 0; k < kMarks; ++k)
        drawMark(&picture, points[points.size() * (k * methods + m) / (kMarks * methods)], m,
                 seriesColour(m));
    }
  }
  return picture;
}

}  // namespace edge_mcl
