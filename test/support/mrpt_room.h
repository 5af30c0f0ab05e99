/// The furnished rooms as MRPT's maps and observations need them.
#pragma once

#include <gtest/gtest.h>
#include <mrpt/img/CImage.h>

#include <fstream>
#include <memory>
#include <string>

#include "edge_mcl/mrpt_plugins/CObservationMaskedImage.h"
#include "edge_mcl/mrpt_plugins/mrpt_conversions.h"
#include "support/scenes.h"

namespace edge_mcl::test {

/// Writes the furnished rooms to a file. @return its name
inline std::string roomFile() {
  std::string file = testing::TempDir() + "rooms.obj";
  const MeshModel mesh = furnishedRooms();
  std::ofstream out(file);
  for (const auto& v : mesh.vertices) out << "v " << v.transpose() << "\n";
  for (const auto& t : mesh.triangles)
    out << "f " << t[0] + 1 << " " << t[1] + 1 << " " << t[2] + 1 << "\n";
  return file;
}

/// Camera pose in the first room, T_map_camera.
const Pose kView = lookAlong({3.2, 2.5, 1.4}, {-1, -0.5, -0.15});

/// The image of a camera at kView in the furnished rooms.
inline CObservationMaskedImage::Ptr roomObservation(const Pose& T_base_camera) {
  static const CameraModel camera = pinhole(320, 240, 250);
  static const cv::Mat picture = render(furnishedRooms(), camera, kView, 1);
  auto obs = std::make_shared<CObservationMaskedImage>();
  obs->cameraParams = toMrpt(camera);
  obs->cameraPose = toMrpt(T_base_camera);
  obs->image = mrpt::img::CImage(picture, mrpt::img::DEEP_COPY);
  return obs;
}

}  // namespace edge_mcl::test
