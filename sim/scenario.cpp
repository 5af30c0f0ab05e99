#include "edge_mcl/sim/scenario.h"

#include <cmath>
#include <filesystem>
#include <functional>
#include <map>

#include "edge_mcl/core/base/angles.h"
#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/base/parameter_struct.h"
#include "edge_mcl/core/base/parameters.h"
#include "edge_mcl/core/base/yaml_file.h"

namespace edge_mcl {

namespace {

/// Reads the keys of one YAML map. A key that nobody reads is a fault.
class KeyReader {
 public:
  KeyReader(const YAML::Node& node, std::string where) : node_(node), where_(std::move(where)) {
    if (!node_.IsMap()) throw InputError(where_ + ": must be a map of keys");
  }
  template <class T>
  KeyReader& optional(const std::string& key, T* value) {
    known_.push_back(key);
    if (!node_[key]) return *this;
    try {
      *value = node_[key].as<T>();
    } catch (const YAML::Exception&) {
      throw InputError(where_ + ": '" + key + "' has a value of the wrong type");
    }
    return *this;
  }
  template <class T>
  KeyReader& required(const std::string& key, T* value) {
    if (!node_[key]) throw InputError(where_ + ": key '" + key + "' is missing");
    return optional(key, value);
  }
  /// Must be called after all keys are read. @throws InputError for an unknown key.
  void finish() const {
    for (const auto& entry : node_) {
      const auto key = entry.first.as<std::string>();
      bool known = false;
      for (const std::string& k : known_) known |= k == key;
      if (!known)
        throw InputError(where_ + ": unknown key '" + key + "' (did you mean '" +
                         nearestName(key, known_) + "'?)");
    }
  }

 private:
  YAML::Node node_;
  std::string where_;
  std::vector<std::string> known_;
};

void requireRange(double value, double low, double high, const std::string& what) {
  if (!(value >= low && value <= high))
    throw InputError(what + " must be between " + std::to_string(low) + " and " +
                     std::to_string(high));
}

Eigen::Vector3d vectorFrom(const std::vector<double>& v, const std::string& where) {
  if (v.size() != 3) throw InputError(where + ": must have three numbers");
  for (const double x : v)
    if (!std::isfinite(x)) throw InputError(where + ": has a number that is not finite");
  return {v[0], v[1], v[2]};
}

FlightPath pathFrom(const YAML::Node& list, bool tilts, const std::string& where) {
  if (!list.IsSequence()) throw InputError(where + ": must be a list of waypoints");
  std::vector<Waypoint> waypoints;
  for (const YAML::Node& node : list) {
    Waypoint w;
    std::vector<double> position;
    double yaw_deg = 0;
    KeyReader(node, where)
        .required("time", &w.time)
        .required("position", &position)
        .optional("yaw_deg", &yaw_deg)
        .finish();
    w.position = vectorFrom(position, where + ": position");
    w.yaw = yaw_deg * kDegree;
    waypoints.push_back(w);
  }
  return FlightPath::throughWaypoints(waypoints, tilts, where);
}

}  // namespace

Scenario Scenario::fromYamlFile(const std::string& file) {
  const YAML::Node root = loadYamlFile(file);
  const auto beside = [&](const std::string& name) {
    return (std::filesystem::path(file).parent_path() / name).lexically_normal().string();
  };
  Scenario s;
  s.file = file;
  std::string model, camera, trajectory;
  YAML::Node path, random, objects, lighting, faults, odometry, imu;
  KeyReader(root, file)
      .required("model", &model)
      .required("camera", &camera)
      .optional("mount_pitch_deg", &s.mount_pitch_deg)
      .optional("rate", &s.rate)
      .optional("path", &path)
      .optional("trajectory", &trajectory)
      .optional("random", &random)
      .optional("clearance", &s.clearance)
      .optional("objects", &objects)
      .optional("lighting", &lighting)
      .optional("faults", &faults)
      .optional("odometry", &odometry)
      .optional("imu", &imu)
      .optional("depth_scale", &s.depth_scale)
      .optional("seed", &s.seed)
      .finish();
  s.model_file = beside(model);
  s.camera = CameraModel::fromYamlFile(beside(camera));
  if (path.IsDefined() && !path.IsNull()) {
    s.path = pathFrom(path, true, file + ": path");
  } else if (!trajectory.empty()) {
    s.path = FlightPath::throughPoses(readTrajectory(beside(trajectory)), beside(trajectory));
    s.path_is_of_camera = true;
  } else if (random.IsDefined() && !random.IsNull()) {
    KeyReader(random, file + ": random")
        .required("duration", &s.random_duration)
        .optional("speed", &s.random_speed)
        .finish();
    requireRange(s.random_duration, 0.1, 3600, file + ": random: duration");
    requireRange(s.random_speed, 0.01, 20, file + ": random: speed");
  } else {
    throw InputError(file + ": neither 'path' nor 'trajectory' nor 'random' is given");
  }
  if (objects.IsDefined() && !objects.IsNull() && !objects.IsSequence())
    throw InputError(file + ": objects: must be a list");
  if (objects.IsDefined() && !objects.IsNull())
    for (const YAML::Node& node : objects) {
      MovableObject object;
      std::string object_model;
      YAML::Node object_path;
      KeyReader(node, file + ": objects")
          .required("name", &object.name)
          .required("model", &object_model)
          .required("path", &object_path)
          .finish();
      object.model_file = beside(object_model);
      object.path = pathFrom(object_path, false, file + ": path of " + object.name);
      s.objects.push_back(std::move(object));
    }
  if (lighting.IsDefined() && !lighting.IsNull()) {
    std::vector<std::vector<double>> lamps;
    KeyReader(lighting, file + ": lighting")
        .optional("ambient", &s.lighting.ambient)
        .optional("lamps", &lamps)
        .optional("shadows", &s.lighting.shadows)
        .finish();
    for (const auto& lamp : lamps)
      s.lighting.lamps.push_back(vectorFrom(lamp, file + ": lighting: lamps").cast<float>());
  }
  if (faults.IsDefined() && !faults.IsNull())
    KeyReader(faults, file + ": faults")
        .optional("noise", &s.faults.noise)
        .optional("exposure_swing", &s.faults.exposure_swing)
        .optional("exposure_period", &s.faults.exposure_period)
        .optional("exposure_time", &s.faults.exposure_time)
        .optional("blur_steps", &s.faults.blur_steps)
        .optional("dropped", &s.faults.dropped)
        .optional("depth_noise", &s.faults.depth_noise)
        .optional("depth_range", &s.faults.depth_range)
        .finish();
  if (odometry.IsDefined() && !odometry.IsNull())
    KeyReader(odometry, file + ": odometry")
        .optional("position", &s.odometry.position)
        .optional("angle_deg", &s.odometry.angle_deg)
        .optional("per_metre", &s.odometry.per_metre)
        .optional("per_radian", &s.odometry.per_radian)
        .finish();
  if (imu.IsDefined() && !imu.IsNull())
    KeyReader(imu, file + ": imu")
        .optional("rate", &s.imu.rate)
        .optional("accelerometer", &s.imu.accelerometer)
        .optional("gyroscope", &s.imu.gyroscope)
        .optional("accelerometer_walk", &s.imu.accelerometer_walk)
        .optional("gyroscope_walk", &s.imu.gyroscope_walk)
        .finish();
  requireRange(s.rate, 0.1, 1000, file + ": rate");
  requireRange(s.imu.rate, 1, 10000, file + ": imu: rate");
  requireRange(s.depth_scale, 1, 65535, file + ": depth_scale");
  requireRange(s.mount_pitch_deg, -90, 90, file + ": mount_pitch_deg");
  requireRange(s.clearance, 0, 100, file + ": clearance");
  requireRange(s.lighting.ambient, 0, 1, file + ": lighting: ambient");
  requireRange(s.faults.noise, 0, 255, file + ": faults: noise");
  requireRange(s.faults.exposure_swing, 0, 0.9, file + ": faults: exposure_swing");
  requireRange(s.faults.exposure_period, 0.01, 1e6, file + ": faults: exposure_period");
  requireRange(s.faults.exposure_time, 0, 1, file + ": faults: exposure_time");
  requireRange(s.faults.blur_steps, 1, 100, file + ": faults: blur_steps");
  requireRange(s.faults.dropped, 0, 0.99, file + ": faults: dropped");
  requireRange(s.faults.depth_noise, 0, 0.1, file + ": faults: depth_noise");
  requireRange(s.faults.depth_range, 0.1, 1000, file + ": faults: depth_range");
  requireRange(s.odometry.position, 0, 100, file + ": odometry: position");
  requireRange(s.odometry.angle_deg, 0, 180, file + ": odometry: angle_deg");
  requireRange(s.odometry.per_metre, 0, 100, file + ": odometry: per_metre");
  requireRange(s.odometry.per_radian, 0, 100, file + ": odometry: per_radian");
  requireRange(s.imu.accelerometer, 0, 1000, file + ": imu: accelerometer");
  requireRange(s.imu.gyroscope, 0, 1000, file + ": imu: gyroscope");
  requireRange(s.imu.accelerometer_walk, 0, 1000, file + ": imu: accelerometer_walk");
  requireRange(s.imu.gyroscope_walk, 0, 1000, file + ": imu: gyroscope_walk");
  return s;
}

Pose Scenario::T_body_camera() const {
  Pose mount = Pose::Identity();
  mount.linear() =
      Eigen::AngleAxisd(mount_pitch_deg * kDegree, Eigen::Vector3d::UnitY()).toRotationMatrix();
  return mount * opticalOnBody();
}

Pose Scenario::cameraAt(double time) const {
  return path_is_of_camera ? path.at(time) : path.at(time) * T_body_camera();
}

}  // namespace edge_mcl
