#include "edge_mcl/audit/map_additions.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <sstream>
#include <utility>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/import/mesh_loader.h"
#include "edge_mcl/core/mesh/closest_point.h"

namespace edge_mcl {

namespace {

constexpr char kThing[] = "thing_";
constexpr char kFirstLine[] = "# what the building has and the model lacks, by edge-mcl audit";

using Line = std::array<Eigen::Vector3d, 2>;

/// Boxes are made of voxels of 0.1 m, and the noise of depth widens surfaces.
constexpr double kAroundBox = 0.1;  // m
/// Fused faces this near to the model are of the model: the fusion has voxels of 2 cm and joins
/// corners within 5 cm.
constexpr double kOfModel = 0.06;  // m
/// A line of which this share lies in the box belongs to the thing.
constexpr double kShare = 0.7;
constexpr int kSteps = 20;  // places of a line that are examined

Eigen::AlignedBox3d around(const Eigen::AlignedBox3d& box) {
  const Eigen::Vector3d margin = Eigen::Vector3d::Constant(kAroundBox);
  return {box.min() - margin, box.max() + margin};
}

bool liesIn(const Eigen::AlignedBox3d& box, const Line& line) {
  int inside = 0;
  for (int i = 0; i <= kSteps; ++i)
    if (box.contains(line[0] + i / static_cast<double>(kSteps) * (line[1] - line[0]))) ++inside;
  return inside >= kShare * kSteps;
}

Eigen::Vector3d middleOf(const MeshSoup& soup, const std::array<uint32_t, 3>& triangle) {
  return ((soup.vertices[triangle[0]] + soup.vertices[triangle[1]] + soup.vertices[triangle[2]]) /
          3)
      .cast<double>();
}

/// The faces of a soup with these numbers, and the vertices that they need.
MeshSoup partOf(const MeshSoup& soup, const std::vector<size_t>& faces) {
  constexpr uint32_t kUnused = UINT32_MAX;
  std::vector<uint32_t> number(soup.vertices.size(), kUnused);
  MeshSoup part;
  for (const size_t face : faces) {
    std::array<uint32_t, 3> triangle = soup.triangles[face];
    for (uint32_t& vertex : triangle) {
      if (number[vertex] == kUnused) {
        number[vertex] = static_cast<uint32_t>(part.vertices.size());
        part.vertices.push_back(soup.vertices[vertex]);
      }
      vertex = number[vertex];
    }
    part.triangles.push_back(triangle);
  }
  return part;
}

std::string vertexText(const Eigen::Vector3d& v) {
  std::array<char, 96> text{};
  std::snprintf(text.data(), text.size(), "v %.4f %.4f %.4f\n", v.x(), v.y(), v.z());
  return text.data();
}

/// Writes lines as an object. @param vertices number of the vertices in the file so far
void write(const std::string& name, const std::vector<Line>& lines, size_t* vertices,
           std::ostringstream* out) {
  if (lines.empty()) return;
  *out << "o " << name << "\n";
  for (const Line& line : lines) {
    *out << vertexText(line[0]) << vertexText(line[1]) << "l " << *vertices + 1 << " "
         << *vertices + 2 << "\n";
    *vertices += 2;
  }
}

}  // namespace

MapAdditions additionsOf(const std::vector<StandingThing>& things,
                         const std::vector<AuditRow>& rows, const MeshSoup& faces,
                         const LocalizationMap& map) {
  MapAdditions additions;
  const Eigen::Vector3d& origin = map.mesh().origin;
  std::unique_ptr<ClosestFace> model;
  if (!map.mesh().triangles.empty()) model = std::make_unique<ClosestFace>(map.mesh());
  // Depth is off by centimetres, and a line behind its wall is never seen.
  const auto onSurface = [&](const Eigen::Vector3d& point) -> Eigen::Vector3d {
    constexpr double kReach = 0.1;  // m
    if (!model) return point;
    const ClosestFace::Hit hit = model->find(point - origin, kReach);
    return hit.found ? hit.point + origin : point;
  };
  for (const AuditRow& row : rows)
    if (row.part == AuditRow::Part::kNew && row.verdict == "marking")
      additions.markings.push_back({onSurface(row.start), onSurface(row.end)});
  std::vector<bool> is_taken(faces.triangles.size(), false), is_line_taken(rows.size(), false);
  for (const StandingThing& thing : things) {
    AddedThing added{thing, {}, {}};
    const Eigen::AlignedBox3d box = around(thing.box);
    for (size_t i = 0; i < rows.size(); ++i) {
      const AuditRow& row = rows[i];
      if (is_line_taken[i] || row.part != AuditRow::Part::kNew || row.verdict != "new" ||
          !liesIn(box, {row.start - origin, row.end - origin}))
        continue;
      added.lines.push_back({row.start, row.end});
      is_line_taken[i] = true;
    }
    std::vector<size_t> of_thing;
    for (size_t i = 0; i < faces.triangles.size(); ++i) {
      if (is_taken[i]) continue;
      const Eigen::Vector3d middle = middleOf(faces, faces.triangles[i]);
      if (!box.contains(middle) || (model && model->find(middle, kOfModel).found)) continue;
      of_thing.push_back(i);
      is_taken[i] = true;
    }
    added.faces = partOf(faces, of_thing);
    if (!added.lines.empty() || !of_thing.empty())
      additions.things.push_back(std::move(added));
    else
      ++additions.without_parts;
  }
  return additions;
}

int highestThing(const std::map<std::string, size_t>& objects) {
  int highest = 0;
  for (const auto& [name, parts] : objects)
    if (name.rfind(kThing, 0) == 0)
      highest = std::max(highest, std::atoi(name.c_str() + std::string(kThing).size()));
  return highest;
}

void writeAdditions(const std::string& file, const MapAdditions& additions,
                    const Eigen::Vector3d& origin) {
  std::ostringstream out;
  out << kFirstLine << "\n# metres\n";
  size_t vertices = 0;
  for (const AddedThing& added : additions.things) {
    const std::string number = std::to_string(added.thing.number);
    write(kThing + number + "_lines", added.lines, &vertices, &out);
    if (added.faces.triangles.empty()) continue;
    out << "o " << kThing << number << "_" << kHidingFaces << "\n";
    for (const Eigen::Vector3f& v : added.faces.vertices)
      out << vertexText(v.cast<double>() + origin);
    for (const auto& t : added.faces.triangles)
      out << "f " << vertices + t[0] + 1 << " " << vertices + t[1] + 1 << " " << vertices + t[2] + 1
          << "\n";
    vertices += added.faces.vertices.size();
  }
  write("markings", additions.markings, &vertices, &out);
  std::ofstream stream(file, std::ios::binary);
  stream << out.str();
  stream.flush();
  if (!stream) throw InputError(file + ": cannot be written");
}

bool isAdditionsFile(const std::string& file) {
  std::ifstream in(file);
  std::string line;
  return std::getline(in, line) && line == kFirstLine;
}

}  // namespace edge_mcl
