/// Rendered images of the furnished rooms, ready to be compared with poses.
#pragma once

#include "edge_mcl/core/localization_map.h"
#include "support/room_view.h"
#include "support/scenes.h"

namespace edge_mcl::test {

/// The image that roomCamera() takes at T_map_camera.
inline CameraView viewInRoom(const LocalizationMap& map, const Pose& T_map_camera = roomView(),
                             const Pose& T_base_camera = Pose::Identity()) {
  const cv::Mat image = T_map_camera.matrix() == roomView().matrix()
                            ? roomPicture()
                            : render(furnishedRooms(), roomCamera(), T_map_camera, 1);
  return {map.prepare(roomCamera(), image, {}, "room"), T_base_camera, 1, nullptr};
}

/// A black image, in which there are no edges.
inline CameraView darkView(const LocalizationMap& map) {
  const cv::Mat dark(roomCamera().height, roomCamera().width, CV_8U, cv::Scalar(0));
  return {map.prepare(roomCamera(), dark, {}, "dark"), Pose::Identity(), 1, nullptr};
}

/// The exact depth image that a camera takes at T_map_camera. There is no colour image.
inline CameraView depthInRoom(const LocalizationMap& map, const Pose& T_map_camera = roomView()) {
  DepthImage image;
  image.camera = pinhole(160, 120, 110);
  image.depth = renderDepth(furnishedRooms(), image.camera, T_map_camera);
  image.origin = "room";
  return {nullptr, Pose::Identity(), 1, map.prepareDepth(image)};
}

/// Parameters for depth images alone. The distance field is not stored on disk.
inline Parameters depthAlone() {
  Parameters params;
  params.likelihood.cues = Cues::kDepth;
  params.depth.store_field = false;
  return params;
}

}  // namespace edge_mcl::test
