/// A model as a reader of files delivers it, before units, axes and welding.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <cstdio>
#include <string>
#include <vector>

namespace edge_mcl {

/// Geometry of a model file with the axes of the file. Vertices are double, so that coordinates of
/// a country keep their millimetres.
struct RawModel {
  std::vector<Eigen::Vector3d> vertices;  ///< in units of the file, or in metres
  std::vector<std::array<uint32_t, 3>> triangles;
  std::vector<uint32_t> triangle_material, triangle_object;  ///< one number for each triangle
  std::vector<std::array<uint32_t, 2>> lines;
  std::vector<uint32_t> line_object;  ///< one number for each line
  std::vector<Eigen::Vector3f> material_colors;
  std::vector<std::string> objects;  ///< names of the objects
  double unit = 0;                   ///< metres per unit of the file; 0: the file does not say
  std::string unit_name;             ///< of a unit that is not the metre
  bool in_metres = false;            ///< the reader has applied the unit
  int32_t up_axis = -1;  ///< axis that the file calls up: 0 x, 1 y, 2 z; -1: it does not say
  /// Error of every vertex by rounding to single precision, in units of the vertices.
  std::vector<float> rounding;
  uint64_t empty_faces = 0;
};

/// Writes a model for readRawModel() of the same computer. @return false when writing fails.
bool writeRawModel(const RawModel& model, std::FILE* file);
/// Reads what writeRawModel() has written, from the current position.
/// @return false when the data are cut off or contradict themselves.
bool readRawModel(std::FILE* file, RawModel* model);

}  // namespace edge_mcl
