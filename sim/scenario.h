/// Reads the YAML description of a simulated flight: model, camera, path, objects, faults, noise.
#pragma once

#include <string>
#include <vector>

#include "edge_mcl/core/camera/camera_model.h"
#include "edge_mcl/sim/camera_faults.h"
#include "edge_mcl/sim/flight_path.h"
#include "edge_mcl/sim/renderer.h"
#include "edge_mcl/sim/sensor_noise.h"

namespace edge_mcl {

/// An object that is not in the map.
struct MovableObject {
  std::string name;
  std::string model_file;
  FlightPath path;  ///< T_map_object, level; before and after the path the object stands still
};

/// All settings of a simulated flight.
struct Scenario {
  std::string file;        ///< named in errors
  std::string model_file;  ///< the building, which becomes the map
  CameraModel camera;
  double mount_pitch_deg = 0;  ///< angle by which the camera looks down
  double rate = 30;            ///< images per second
  /// T_map_body (x forward, z up). For the key `trajectory` (recorded poses): T_map_camera.
  FlightPath path;
  bool path_is_of_camera = false;
  /// Random flight in place of a path. The simulator makes it when the duration is not 0.
  double random_duration = 0, random_speed = 0.8;  ///< s, m/s
  double clearance = 0.15;  ///< m; smallest distance from the path to any face of the building
  std::vector<MovableObject> objects;
  Lighting lighting;
  CameraFaults faults;
  OdometryNoise odometry;
  ImuNoise imu;
  double depth_scale = 5000;  ///< units of the depth images per metre
  uint64_t seed = 1;

  /// Reads a scenario. Paths in the file are relative to its folder.
  /// @throws InputError with file, key and fault; an unknown key is a fault.
  static Scenario fromYamlFile(const std::string& file);

  /// Mounting of the camera: forward, pitched down by mount_pitch_deg.
  Pose T_body_camera() const;
  /// T_map_camera at a time (s).
  Pose cameraAt(double time) const;
};

}  // namespace edge_mcl
