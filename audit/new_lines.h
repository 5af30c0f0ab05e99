/// Lines that images show and the model lacks.
#pragma once

#include <vector>

#include "edge_mcl/core/edges/audit_table.h"
#include "edge_mcl/core/localization_map.h"
#include "edge_mcl/mapping/line_tracks.h"

namespace edge_mcl {

/// Keeps the lines that no model line explains. Their rows have the verdict `new` where the model
/// has no surface, and `marking` on a surface (a poster, a shadow). New lines that meet belong to
/// one object, whose number is the shape of their rows; markings have -1.
/// @param lines in the map frame.
std::vector<AuditRow> findNewLines(const std::vector<MappedLine>& lines,
                                   const LocalizationMap& map);

/// An object that the model lacks.
struct NewObject {
  int number = 0;
  size_t lines = 0;
  Eigen::Vector3d lowest, highest;  ///< of its lines, as in the rows, m
};
/// Objects of at least three new lines.
std::vector<NewObject> newObjects(const std::vector<AuditRow>& rows);

}  // namespace edge_mcl
