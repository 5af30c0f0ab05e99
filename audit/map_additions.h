/// What a building has and its model lacks, as a file that a map can take (`map.additions`).
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <map>
#include <string>
#include <vector>

#include "edge_mcl/core/edges/audit_table.h"
#include "edge_mcl/core/localization_map.h"

namespace edge_mcl {

/// A thing that the model lacks and that has not moved.
struct StandingThing {
  int number = 0;
  Eigen::AlignedBox3d box;  ///< in the axes of the map, m
  double stood_for = 0;     ///< between the first and the last image that shows it, s
};

/// A standing thing with its lines and surfaces.
struct AddedThing {
  StandingThing thing;
  /// Ends in the coordinates of the model file after scale and transform, m.
  std::vector<std::array<Eigen::Vector3d, 2>> lines;
  MeshSoup faces;  ///< map frame, m
};

/// Parts that a map can take.
struct MapAdditions {
  std::vector<AddedThing> things;
  /// Lines on surfaces of the model: posters, joints. Coordinates as of AddedThing::lines.
  std::vector<std::array<Eigen::Vector3d, 2>> markings;
  size_t without_parts = 0;  ///< things that have neither lines nor faces, and are left out
};

/// Gives every standing thing the new lines and the fused faces that lie in its box. New lines
/// outside of all boxes are left out: what they belong to has moved, or was not seen for long. A
/// thing without lines and faces is left out.
/// @param rows of an audit. @param faces fused from depth images, map frame, m; those on surfaces
/// of the model are left out.
MapAdditions additionsOf(const std::vector<StandingThing>& things,
                         const std::vector<AuditRow>& rows, const MeshSoup& faces,
                         const LocalizationMap& map);

/// Highest N of the objects thing_N... that a model has, so that new things get other numbers; 0:
/// it has none.
/// @param objects see MeshReport::objects
int highestThing(const std::map<std::string, size_t>& objects);

/// Writes an OBJ file, metres: objects thing_N_lines, thing_N_hiding_faces and markings.
/// `map.exclude` can leave each of them out.
/// @param origin of the map frame in the coordinates of the lines, m
/// @throws InputError when the file cannot be written.
void writeAdditions(const std::string& file, const MapAdditions& additions,
                    const Eigen::Vector3d& origin);
/// Whether writeAdditions() has written a file.
bool isAdditionsFile(const std::string& file);

}  // namespace edge_mcl
