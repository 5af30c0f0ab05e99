/// A depth camera in the furnished rooms, and the distance field of the rooms.
#pragma once

#include <memory>

#include "edge_mcl/core/depth/depth_points.h"
#include "edge_mcl/core/depth/distance_field.h"
#include "support/room_view.h"
#include "support/scenes.h"

namespace edge_mcl::test {

/// Exact depth image of the furnished rooms. @param view pose of the depth camera, T_map_depth
inline DepthImage roomDepth(const Pose& view = roomView()) {
  DepthImage image;
  image.camera = pinhole(160, 120, 125);
  image.depth = renderDepth(furnishedRooms(), image.camera, view);
  image.origin = "room";
  return image;
}

/// Distance field of the furnished rooms with the default options. It is made once.
inline std::shared_ptr<const DistanceField> roomField() {
  static const auto field =
      std::make_shared<const DistanceField>(furnishedRooms(), DistanceField::Options());
  return field;
}

}  // namespace edge_mcl::test
