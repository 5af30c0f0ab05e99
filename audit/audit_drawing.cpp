#include "edge_mcl/audit/audit_drawing.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <sstream>
#include <utility>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/drawing/line_view.h"

namespace edge_mcl {

namespace {

struct Verdict {
  const char* name;
  cv::Scalar colour;
  int width;
};

/// What is wrong is drawn last and thick. Colours of Okabe and Ito, which colour-blind readers can
/// tell apart.
const std::vector<Verdict>& verdicts() {
  static const std::vector<Verdict> list{
      {"unseen", {190, 190, 190}, 1}, {"confirmed", {115, 158, 0}, 1},
      {"doubtful", {0, 159, 230}, 2}, {"marking", {233, 180, 86}, 1},
      {"gone", {0, 94, 213}, 3},      {"new", {167, 121, 204}, 3}};
  return list;
}

bool isLine(const AuditRow& row) { return row.part != AuditRow::Part::kShape; }

double lengthOf(const AuditRow& row) { return (row.end - row.start).norm(); }

}  // namespace

std::vector<std::pair<std::string, double>> lengthsOf(const std::vector<AuditRow>& rows) {
  std::vector<std::pair<std::string, double>> lengths;
  for (const char* name : {"confirmed", "unseen", "doubtful", "gone", "new", "marking"}) {
    lengths.emplace_back(name, 0);
    for (const AuditRow& row : rows)
      if (isLine(row) && row.verdict == name) lengths.back().second += lengthOf(row);
  }
  return lengths;
}

cv::Mat drawAudit(const std::vector<AuditRow>& rows, cv::Size size) {
  DrawnBox box{Eigen::Vector3d::Constant(INFINITY), Eigen::Vector3d::Constant(-INFINITY)};
  for (const AuditRow& row : rows)
    for (const Eigen::Vector3d& end : {row.start, row.end}) {
      box.lowest = box.lowest.cwiseMin(end);
      box.highest = box.highest.cwiseMax(end);
    }
  if (rows.empty()) box = {Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
  std::vector<DrawnLine> lines;
  std::vector<LegendEntry> legend;
  for (const Verdict& verdict : verdicts()) {
    double length = 0;
    for (const AuditRow& row : rows) {
      if (!isLine(row) || row.verdict != verdict.name) continue;
      lines.push_back({row.start, row.end, verdict.colour, verdict.width});
      length += lengthOf(row);
    }
    std::array<char, 64> text{};
    std::snprintf(text.data(), text.size(), "%s  %.1f m", verdict.name, length);
    if (length > 0) legend.push_back({text.data(), verdict.colour});
  }
  return drawLineView(lines, box, legend, size);
}

void writeAuditObj(const std::string& file, const std::vector<AuditRow>& rows) {
  std::ostringstream out;
  out << "# lines of a model by the verdict of edge-mcl audit, metres\n";
  size_t vertices = 0;
  for (const Verdict& verdict : verdicts()) {
    bool is_first = true;
    for (const AuditRow& row : rows) {
      if (!isLine(row) || row.verdict != verdict.name) continue;
      if (is_first) out << "o " << verdict.name << "\n";
      is_first = false;
      for (const Eigen::Vector3d& v : {row.start, row.end}) {
        std::array<char, 96> text{};
        std::snprintf(text.data(), text.size(), "v %.4f %.4f %.4f\n", v.x(), v.y(), v.z());
        out << text.data();
      }
      out << "l " << vertices + 1 << " " << vertices + 2 << "\n";
      vertices += 2;
    }
  }
  std::ofstream stream(file, std::ios::binary);
  stream << out.str();
  stream.flush();
  if (!stream) throw InputError(file + ": cannot be written");
}

}  // namespace edge_mcl
