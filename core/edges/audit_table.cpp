#include "edge_mcl/core/edges/audit_table.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <locale>
#include <set>
#include <sstream>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/mesh/mesh_shapes.h"

namespace edge_mcl {

namespace {

constexpr const char* kNames =
    "part,x1,y1,z1,x2,y2,z2,shape,viewpoints,shown,by_chance,confidence,verdict";
constexpr size_t kColumns = 13;
constexpr std::array<const char*, 3> kParts{"line", "shape", "new"};

std::vector<std::string> cellsOf(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream in(line);
  for (std::string cell; std::getline(in, cell, ',');) cells.push_back(cell);
  return cells;
}

bool readNumber(const std::string& text, double* value) {
  std::istringstream in(text);
  in.imbue(std::locale::classic());
  char rest = 0;
  return (in >> *value) && std::isfinite(*value) && !(in >> rest);
}

bool readRow(const std::vector<std::string>& cells, AuditRow* row) {
  if (cells.size() != kColumns) return false;
  const auto* part = std::find(kParts.begin(), kParts.end(), cells[0]);
  if (part == kParts.end()) return false;
  row->part = static_cast<AuditRow::Part>(part - kParts.begin());
  std::array<double, kColumns - 2> numbers{};
  for (size_t k = 0; k < numbers.size(); ++k)
    if (!readNumber(cells[k + 1], &numbers[k])) return false;
  row->start = Eigen::Vector3d(numbers[0], numbers[1], numbers[2]);
  row->end = Eigen::Vector3d(numbers[3], numbers[4], numbers[5]);
  constexpr double kMost = 1e9;  // fits an int
  if (std::abs(numbers[6]) > kMost || std::abs(numbers[7]) > kMost) return false;
  row->shape = static_cast<int>(numbers[6]);
  row->viewpoints = static_cast<int>(numbers[7]);
  row->shown = numbers[8];
  row->by_chance = numbers[9];
  row->confidence = numbers[10];
  row->verdict = cells.back();
  return row->confidence >= 0 && row->confidence <= 1;
}

}  // namespace

void writeAuditTable(const std::string& file, const std::vector<AuditRow>& rows) {
  std::ofstream out(file, std::ios::binary);
  out << kNames << "\n";
  for (const AuditRow& r : rows) {
    std::array<char, 256> text{};
    std::snprintf(
        text.data(), text.size(), "%s,%.4f,%.4f,%.4f,%.4f,%.4f,%.4f,%d,%d,%.3f,%.3f,%.4f,",
        kParts.at(static_cast<size_t>(r.part)), r.start.x(), r.start.y(), r.start.z(), r.end.x(),
        r.end.y(), r.end.z(), r.shape, r.viewpoints, r.shown, r.by_chance, r.confidence);
    out << text.data() << r.verdict << "\n";
  }
  out.flush();
  if (!out) throw InputError(file + ": cannot be written");
}

std::vector<AuditRow> readAuditTable(const std::string& file) {
  std::ifstream in(file);
  std::string line;
  if (!in) throw InputError(file + ": cannot be read");
  if (!std::getline(in, line) || line.substr(0, line.find('\r')) != kNames)
    throw InputError(file + ": is not a table of edge-mcl audit (its first line must be '" +
                     kNames + "')");
  std::vector<AuditRow> rows;
  for (size_t number = 2; std::getline(in, line); ++number) {
    line = line.substr(0, line.find('\r'));
    if (line.empty()) continue;
    AuditRow row;
    if (!readRow(cellsOf(line), &row))
      throw InputError(file + ":" + std::to_string(number) +
                       ": is not a row of an audit (13 values, confidence between 0 and 1)");
    rows.push_back(row);
  }
  return rows;
}

void leaveOutDoubted(const std::vector<AuditRow>& rows, double least_confidence, MeshModel* mesh) {
  constexpr double kSame = 2e-3;  // m; the table is rounded to 0.1 mm
  const MeshShapes shapes = findShapes(*mesh);
  std::vector<bool> gone(shapes.count(), false);
  size_t unknown = 0;
  std::set<int> removed;  // numbers of shapes; their lines go with them
  for (const AuditRow& row : rows) {
    if (row.part != AuditRow::Part::kShape || row.confidence >= least_confidence) continue;
    const Eigen::Vector3d start = row.start - mesh->origin, end = row.end - mesh->origin;
    bool found = false;
    for (size_t i = 0; i < shapes.count(); ++i)
      if ((shapes.box[i].min().cast<double>() - start).cwiseAbs().maxCoeff() < kSame &&
          (shapes.box[i].max().cast<double>() - end).cwiseAbs().maxCoeff() < kSame)
        gone[i] = found = true;
    unknown += found ? 0 : 1;
    if (found) removed.insert(row.shape);
  }
  for (const AuditRow& row : rows)
    if (row.part == AuditRow::Part::kLine && row.confidence < least_confidence &&
        removed.count(row.shape) == 0)
      mesh->left_out.push_back({row.start - mesh->origin, row.end - mesh->origin});
  if (unknown > 0)
    mesh->report.warnings.push_back(
        std::to_string(unknown) +
        " shapes of map.confidence are not in the model. Is the table that of another model, or "
        "with other map parameters?");
  const auto count = std::count(gone.begin(), gone.end(), true);
  if (count == 0) return;
  mesh->report.warnings.push_back("map.confidence leaves out " + std::to_string(count) + " shapes");
  size_t kept = 0;
  for (size_t t = 0; t < mesh->triangles.size(); ++t) {
    if (gone[shapes.of_triangle[t]]) continue;
    mesh->triangles[kept] = mesh->triangles[t];
    mesh->triangle_material[kept] = mesh->triangle_material[t];
    if (!mesh->hides_only.empty()) mesh->hides_only[kept] = mesh->hides_only[t];
    ++kept;
  }
  mesh->triangles.resize(kept);
  mesh->triangle_material.resize(kept);
  if (!mesh->hides_only.empty()) mesh->hides_only.resize(kept);
  if (mesh->triangles.empty() && mesh->lines.empty())
    throw InputError("map.confidence leaves nothing of the model");
}

}  // namespace edge_mcl
