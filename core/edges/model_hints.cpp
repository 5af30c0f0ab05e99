#include "edge_mcl/core/edges/model_hints.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>
#include <sstream>
#include <utility>

namespace edge_mcl {

namespace {

using Eigen::Vector3d;

/// Half the cross product of two sides: the normal with the triangle's area as its length.
Vector3d areaVector(const MeshModel& mesh, size_t triangle) {
  const auto& t = mesh.triangles[triangle];
  const Vector3d a = mesh.vertices[t[0]].cast<double>();
  return 0.5 *
         (mesh.vertices[t[1]].cast<double>() - a).cross(mesh.vertices[t[2]].cast<double>() - a);
}

/// Axis that a triangle faces within 8 degrees, or -1.
int axisOf(const Vector3d& area) {
  int axis = 0;
  const double most = area.cwiseAbs().maxCoeff(&axis);
  return most > 0.99 * area.norm() ? axis : -1;
}

/// Axis along which floors and ceilings face: the largest area, and less height than the building
/// is wide. -1: cannot be told.
int likelyUpAxis(const MeshModel& mesh) {
  std::array<double, 3> area{};
  for (size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Vector3d v = areaVector(mesh, i);
    if (const int axis = axisOf(v); axis >= 0) area[axis] += v.norm();
  }
  const auto up = static_cast<int>(std::max_element(area.begin(), area.end()) - area.begin());
  const Eigen::Vector3f size = mesh.highest - mesh.lowest;
  // Floor and ceiling of a room of 6 x 4 x 2.7 m have 1.5 times the area of its longer walls.
  constexpr double kClearly = 1.2;
  for (int k = 0; k < 3; ++k)
    if (k != up && (area[up] < kClearly * area[k] || size[up] >= size[k])) return -1;
  return up;
}

/// Distance of the two heights with the largest horizontal areas, which are a floor and a ceiling.
std::optional<double> storeyHeight(const MeshModel& mesh, int up) {
  constexpr int kBins = 400;
  const auto low = static_cast<double>(mesh.lowest[up]);
  const auto height = static_cast<double>(mesh.highest[up] - mesh.lowest[up]);
  if (height <= 0) return std::nullopt;
  std::vector<double> area(kBins, 0);
  for (size_t i = 0; i < mesh.triangles.size(); ++i) {
    const Vector3d v = areaVector(mesh, i);
    if (axisOf(v) != up) continue;
    const auto at = static_cast<double>(mesh.vertices[mesh.triangles[i][0]][up]);
    area[std::clamp(static_cast<int>((at - low) / height * kBins), 0, kBins - 1)] += v.norm();
  }
  const auto first = std::max_element(area.begin(), area.end()) - area.begin();
  constexpr long kSlab = kBins / 8;  // both faces of one slab are one height
  double most = 0;
  long second = -1;
  for (long b = 0; b < kBins; ++b)
    if (std::abs(b - first) > kSlab && area[b] > most) {
      most = area[b];
      second = b;
    }
  if (second < 0 || most < 0.2 * area[first]) return std::nullopt;
  return std::abs(static_cast<double>(second - first)) / kBins * height;
}

std::string number(double value) {
  std::ostringstream text;
  text.precision(3);
  text << value;
  return text.str();
}

void hintAtUnit(const MeshModel& mesh, int up, std::vector<std::string>* hints) {
  const std::optional<double> height = storeyHeight(mesh, up < 0 ? 2 : up);
  if (!height) return;
  struct Unit {
    const char *name, *scale;
    double metres;
  };
  static constexpr std::array<Unit, 3> kUnits{{{"millimetres", "0.001", 0.001},
                                               {"centimetres", "0.01", 0.01},
                                               {"inches", "0.0254", 0.0254}}};
  for (const Unit& unit : kUnits) {
    const double metres = *height * unit.metres;
    if (metres < 2.1 || metres > 5 || *height < 60) continue;
    hints->push_back("floor and ceiling are " + number(*height) + " m apart. Is the model in " +
                     unit.name + "? Then set map.scale to " + unit.scale);
    return;
  }
}

/// Parts whose triangles are connected, by their vertices.
std::vector<uint32_t> componentOfVertices(const MeshModel& mesh) {
  std::vector<uint32_t> parent(mesh.vertices.size());
  std::iota(parent.begin(), parent.end(), uint32_t{0});
  const auto find = [&](uint32_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  for (const auto& t : mesh.triangles)
    for (int k = 1; k < 3; ++k) parent[find(t[k])] = find(t[0]);
  for (uint32_t i = 0; i < parent.size(); ++i) parent[i] = find(i);
  return parent;
}

/// Numbers of closed bodies whose faces are wound outward and inward. A mirrored model has its
/// bodies inside out.
std::pair<size_t, size_t> bodiesByWinding(const MeshModel& mesh) {
  const std::vector<uint32_t> component = componentOfVertices(mesh);
  // The area vectors of a closed surface add up to zero.
  std::vector<Vector3d> sum(mesh.vertices.size(), Vector3d::Zero());
  std::vector<double> volume(mesh.vertices.size(), 0), area(mesh.vertices.size(), 0);
  const Vector3d middle = (0.5f * (mesh.lowest + mesh.highest)).cast<double>();
  for (size_t i = 0; i < mesh.triangles.size(); ++i) {
    const uint32_t c = component[mesh.triangles[i][0]];
    const Vector3d v = areaVector(mesh, i);
    sum[c] += v;
    area[c] += v.norm();
    volume[c] += v.dot(mesh.vertices[mesh.triangles[i][0]].cast<double>() - middle) / 3;
  }
  std::pair<size_t, size_t> count{0, 0};
  for (size_t c = 0; c < area.size(); ++c) {
    if (area[c] <= 0 || sum[c].norm() > 1e-3 * area[c]) continue;
    if (std::abs(volume[c]) < 1e-6 * std::pow(area[c], 1.5)) continue;
    ++(volume[c] > 0 ? count.first : count.second);
  }
  return count;
}

}  // namespace

bool looksLikeScan(const MeshModel& mesh, const EdgeModel& edges) {
  constexpr size_t kFewest = 5000;  // triangles; a smaller scan shows no room
  constexpr double kShort = 0.03;   // of the model's diagonal
  constexpr double kSurfaceShare =
      0.9;  // of a scan is small triangles; of a building walls are not
  constexpr double kEdgeShare = 0.5;
  if (mesh.triangles.size() < kFewest) return false;
  const double longest = kShort * mesh.diagonal();
  double small = 0, all = 0;
  for (size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto& t = mesh.triangles[i];
    double side = 0;
    for (int k = 0; k < 3; ++k)
      side = std::max(
          side, static_cast<double>((mesh.vertices[t[k]] - mesh.vertices[t[(k + 1) % 3]]).norm()));
    const double area = areaVector(mesh, i).norm();
    all += area;
    if (side < longest) small += area;
  }
  double short_edges = 0, all_edges = 0;
  for (const EdgeLine& line : edges.lines) {
    if (line.kind != EdgeKind::kCrease && line.kind != EdgeKind::kBoundary) continue;
    const auto length = static_cast<double>(line.length());
    all_edges += length;
    if (length < longest) short_edges += length;
  }
  return small > kSurfaceShare * all && short_edges > kEdgeShare * all_edges;
}

std::vector<std::string> modelHints(const MeshModel& mesh, const EdgeModel& edges) {
  std::vector<std::string> hints;
  if (mesh.triangles.empty()) return hints;
  if (looksLikeScan(mesh, edges)) {
    hints.push_back("this looks like a scan: " + std::to_string(edges.countOf(EdgeKind::kCrease)) +
                    " creases, most of them short. They are noise and not edges of the building. "
                    "edge-mcl map makes a map of straight lines and faces of it");
    return hints;
  }
  const int up = likelyUpAxis(mesh);
  hintAtUnit(mesh, up, &hints);
  if (up == 1)
    hints.emplace_back(
        "most horizontal surfaces face y. Is y up? Then map.roll_deg=90 makes z the upward axis");
  if (up == 0)
    hints.emplace_back(
        "most horizontal surfaces face x. Is x up? Then map.pitch_deg=-90 makes z the upward axis");
  const auto [outward, inward] = bodiesByWinding(mesh);
  constexpr size_t kFewestBodies = 3;  // one room modelled from inside is inward, too
  if (inward >= kFewestBodies && inward > 3 * outward)
    hints.push_back(std::to_string(inward) + " of " + std::to_string(inward + outward) +
                    " closed bodies are inside out. Is the model mirrored? Then set map.mirror to "
                    "the mirrored axis");
  return hints;
}

}  // namespace edge_mcl
