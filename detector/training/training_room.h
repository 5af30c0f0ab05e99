/// Rooms nobody has seen: walls, fittings, furniture that belongs to the building, movable objects.
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "edge_mcl/detector/training/surface_pattern.h"
#include "edge_mcl/detector/training/training_objects.h"

namespace edge_mcl {

struct PlacedObject {
  const TrainingObject* object = nullptr;
  Eigen::Affine3f T_room_object = Eigen::Affine3f::Identity();
  std::vector<SurfacePattern> patterns;  ///< by material
};

struct TrainingRoom {
  MeshModel mesh;                        ///< walls and fittings, metres, z up, a corner at 0
  std::vector<SurfacePattern> patterns;  ///< by material of the mesh
  std::vector<PlacedObject> objects;
  Eigen::Vector3f size;
  std::vector<Eigen::Vector3f> lamps;
  float ambient = 0.45f;
  bool shadows = true;
};

/// A third of the rooms is plain, without patterns and shadows, as CAD models and their simulation
/// look; one in ten holds nothing movable.
TrainingRoom randomRoom(TrainingRandom& random, const TrainingObjects& objects);

}  // namespace edge_mcl
