#include "edge_mcl/mapping/map_file.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <sstream>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/import/mesh_loader.h"

namespace edge_mcl {

namespace {

/// Upper limits of the standard deviation in the groups of lines, mm. A line belongs to the first
/// that is not smaller.
constexpr std::array<int, 5> kGroups{5, 10, 20, 40, 80};

size_t groupOf(const MappedLine& line) {
  size_t group = 0;
  while (group + 1 < kGroups.size() && line.sigma * 1000 > kGroups[group]) ++group;
  return group;
}

std::string vertexText(const Eigen::Vector3d& v) {
  std::array<char, 96> text{};
  std::snprintf(text.data(), text.size(), "v %.4f %.4f %.4f\n", v.x(), v.y(), v.z());
  return text.data();
}

}  // namespace

void writeMapFile(const std::string& file, const std::vector<MappedLine>& lines,
                  const MeshSoup& hiding_faces, const Eigen::Vector3d& origin,
                  const std::string& comment) {
  std::ostringstream out;
  out << "# " << comment << "\n# metres\n";
  size_t vertices = 0;
  for (size_t group = 0; group < kGroups.size(); ++group) {
    bool is_first = true;
    for (const MappedLine& line : lines) {
      if (groupOf(line) != group) continue;
      if (is_first) out << "o lines_" << kGroups[group] << "mm\n";
      is_first = false;
      out << vertexText(line.start) << vertexText(line.end) << "l " << vertices + 1 << " "
          << vertices + 2 << "\n";
      vertices += 2;
    }
  }
  if (!hiding_faces.triangles.empty()) {
    out << "o " << kHidingFaces << "\n";
    for (const Eigen::Vector3f& v : hiding_faces.vertices)
      out << vertexText(v.cast<double>() + origin);
    for (const auto& t : hiding_faces.triangles)
      out << "f " << vertices + t[0] + 1 << " " << vertices + t[1] + 1 << " " << vertices + t[2] + 1
          << "\n";
  }
  std::ofstream stream(file, std::ios::binary);
  stream << out.str();
  stream.flush();
  if (!stream) throw InputError(file + ": cannot be written");
}

}  // namespace edge_mcl
