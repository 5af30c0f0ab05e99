/// A flight as described by a YAML file: model, camera, path, moving objects, faults, noise.
#pragma once

#include <string>
#include <vector>

#include "edge_mcl/core/camera/camera_model.h"
#include "edge_mcl/sim/camera_faults.h"
#include "edge_mcl/sim/flight_path.h"
#include "edge_mcl/sim/renderer.h"
#include "edge_mcl/sim/sensor_noise.h"

namespace edge_mcl {

/// Something that is not in the map.
struct MovableObject {
  std::string name;
  std::string model_file;
  FlightPath path;  ///< of its origin, level; constant before and after
};

struct Scenario {
  std::string file;        ///< named in errors
  std::string model_file;  ///< the building, which becomes the map
  CameraModel camera;
  double mount_pitch_deg = 0;  ///< the camera looks down by so much
  double rate = 30;            ///< images per second
  FlightPath path;  ///< of the body (x forward, z up), or of the camera for recorded poses
  bool path_is_of_camera = false;
  /// Instead of a path: made by the simulator when the duration is not zero.
  double random_duration = 0, random_speed = 0.8;  ///< s, m/s
  double clearance = 0.15;                         ///< m; the path keeps so far from every face
  std::vector<MovableObject> objects;
  Lighting lighting;
  CameraFaults faults;
  OdometryNoise odometry;
  ImuNoise imu;
  double depth_scale = 5000;  ///< units of the depth images per metre
  uint64_t seed = 1;

  /// @throws InputError naming file, key and fault; unknown keys are faults.
  static Scenario fromYamlFile(const std::string& file);

  Pose T_body_camera() const;
  Pose cameraAt(double time) const;
};

}  // namespace edge_mcl
