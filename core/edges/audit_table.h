/// The table of an audit: how sure it is that the parts of a model exist. See docs/audit.md.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "edge_mcl/core/mesh/mesh_model.h"

namespace edge_mcl {

/// A part of the model, or a line that is not in the model.
struct AuditRow {
  enum class Part {
    kLine,   ///< a piece of a model line
    kShape,  ///< a shape of the mesh; start and end are the corners of its box
    kNew     ///< a line that the images show and the model lacks
  };
  Part part = Part::kLine;
  /// Ends in the coordinates of the model file after scale and transform of the map parameters, m.
  Eigen::Vector3d start = Eigen::Vector3d::Zero(), end = Eigen::Vector3d::Zero();
  int shape = -1;         ///< number of its shape; -1: none
  int viewpoints = 0;     ///< places from which it was seen well
  double shown = 0;       ///< share of its samples that the images showed, mean over the viewpoints
  double by_chance = 0;   ///< the same share beside the line, where the model has none
  double confidence = 1;  ///< probability that it exists, 0 to 1
  std::string verdict;    ///< confirmed, unseen, doubtful, gone or new
};

/// Writes FILE as comma-separated values with a line of names. @throws InputError
void writeAuditTable(const std::string& file, const std::vector<AuditRow>& rows);
/// @throws InputError that names the file, and the line of the first fault.
std::vector<AuditRow> readAuditTable(const std::string& file);

/// Leaves the doubted parts out of a mesh: faces of doubted shapes are removed, and pieces of
/// doubted lines are noted in MeshModel::left_out. It warns of shapes that the mesh does not have.
/// @param least_confidence rows with a lower confidence are doubted.
/// @throws InputError when nothing of the mesh remains.
void leaveOutDoubted(const std::vector<AuditRow>& rows, double least_confidence, MeshModel* mesh);

}  // namespace edge_mcl
