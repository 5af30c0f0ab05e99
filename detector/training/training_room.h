/// Makes random rooms with walls, fittings, furniture and movable objects.
#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "edge_mcl/detector/training/surface_pattern.h"
#include "edge_mcl/detector/training/training_objects.h"

namespace edge_mcl {

/// An object at its place in the room.
struct PlacedObject {
  const TrainingObject* object = nullptr;
  Eigen::Affine3f T_room_object = Eigen::Affine3f::Identity();
  std::vector<SurfacePattern> patterns;  ///< by material
};

/// A room. The origin of its frame is a corner of the floor, z points up, units are metres.
struct TrainingRoom {
  MeshModel mesh;                        ///< walls, fittings and furniture
  std::vector<SurfacePattern> patterns;  ///< by material of the mesh
  std::vector<PlacedObject> objects;
  Eigen::Vector3f size;
  std::vector<Eigen::Vector3f> lamps;  ///< positions
  float ambient = 0.45f;               ///< share of the light that comes from all directions
  bool shadows = true;
};

/// Makes a random room. A third of the rooms is plain, without patterns and mostly without shadows,
/// like CAD models and their simulation. One room in ten has no movable objects.
TrainingRoom randomRoom(TrainingRandom& random, const TrainingObjects& objects);

}  // namespace edge_mcl
