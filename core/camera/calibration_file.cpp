// Reads calibration files of several tools. All of them are YAML with different keys.
#include <array>
#include <filesystem>
#include <vector>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/base/yaml_file.h"
#include "edge_mcl/core/camera/camera_model.h"

namespace edge_mcl {

namespace {

constexpr const char* kFormats =
    "the formats are those of ROS camera_calibration, OpenCV, Kalibr, EuRoC, ORB-SLAM and "
    "VINS-Fusion";

/// Access to the keys of one file, with errors that name both.
class Keys {
 public:
  Keys(const YAML::Node& node, std::string origin) : node_(node), origin_(std::move(origin)) {}

  const std::string& origin() const { return origin_; }
  bool has(const char* key) const { return node_.IsMap() && node_[key]; }
  YAML::Node at(const char* key) const {
    if (!has(key)) throw InputError(origin_ + ": key '" + key + "' is missing");
    return node_[key];
  }
  template <class T>
  T as(const char* key) const {
    const YAML::Node value = at(key);
    try {
      return value.as<T>();
    } catch (const YAML::Exception&) {
      throw InputError(origin_ + ": key '" + key + "' has a value of the wrong kind");
    }
  }
  double number(const std::string& key) const { return as<double>(key.c_str()); }
  /// 0 when the key is missing.
  double numberOrZero(const std::string& key) const { return has(key.c_str()) ? number(key) : 0.0; }
  Keys below(const char* key) const { return {at(key), origin_ + ": " + key}; }
  /// A list of numbers, or a matrix with its numbers under `data`.
  std::vector<double> numbers(const char* key) const {
    if (at(key).IsMap()) return below(key).as<std::vector<double>>("data");
    return as<std::vector<double>>(key);
  }
  /// Names of the entries that are maps.
  std::vector<std::string> maps() const {
    std::vector<std::string> names;
    if (!node_.IsMap()) return names;
    for (const auto& entry : node_)
      if (entry.second.IsMap()) names.push_back(entry.first.as<std::string>());
    return names;
  }

 private:
  YAML::Node node_;
  std::string origin_;
};

CameraModel cameraOf(int width, int height, const std::array<double, 4>& pinhole,
                     const std::string& model, const std::vector<double>& d,
                     const std::string& origin) {
  const auto& [fx, fy, cx, cy] = pinhole;
  return CameraModel::fromFields(width, height, {fx, 0, cx, 0, fy, cy, 0, 0, 1}, model, d.data(),
                                 d.size(), origin);
}

/// ROS camera_calibration, and OpenCV's calibration samples, which leave the model out.
CameraModel fromCameraMatrix(const Keys& file) {
  const std::vector<double> list = file.numbers("camera_matrix");
  if (list.size() != 9) throw InputError(file.origin() + ": camera_matrix must have 9 numbers");
  std::array<double, 9> k{};
  std::copy(list.begin(), list.end(), k.begin());
  const std::vector<double> d = file.numbers("distortion_coefficients");
  std::string model;
  for (const char* key : {"distortion_model", "camera_model"})
    if (model.empty() && file.has(key) && !file.at(key).IsNull()) model = file.as<std::string>(key);
  if (model.empty() && file.has("fisheye_model") && file.number("fisheye_model") != 0)
    model = "fisheye";
  return CameraModel::fromFields(file.as<int>("image_width"), file.as<int>("image_height"), k,
                                 model, d.data(), d.size(), file.origin());
}

/// One camera of Kalibr's camchain, or EuRoC's sensor.yaml.
CameraModel fromIntrinsics(const Keys& camera) {
  if (camera.has("camera_model") && camera.as<std::string>("camera_model") != "pinhole")
    throw InputError(camera.origin() + ": camera_model '" + camera.as<std::string>("camera_model") +
                     "' is not supported; calibrate with pinhole-radtan or pinhole-equi");
  const std::vector<double> k = camera.numbers("intrinsics");
  const auto size = camera.as<std::vector<int>>("resolution");
  if (k.size() != 4 || size.size() != 2)
    throw InputError(camera.origin() +
                     ": intrinsics must be fu, fv, cu, cv, and resolution "
                     "width, height");
  const char* key =
      camera.has("distortion_coeffs") ? "distortion_coeffs" : "distortion_coefficients";
  return cameraOf(size[0], size[1], {k[0], k[1], k[2], k[3]},
                  camera.as<std::string>("distortion_model"), camera.numbers(key), camera.origin());
}

/// ORB-SLAM. @param prefix "Camera." (2 and 3) or "Camera1." (3).
CameraModel fromOrbSlam(const Keys& file, const std::string& prefix) {
  const auto number = [&](const char* name) { return file.number(prefix + name); };
  const auto optional = [&](const char* name) { return file.numberOrZero(prefix + name); };
  for (const char* key : {"Camera.width", "Camera.height"})
    if (!file.has(key))
      throw InputError(file.origin() + ": key '" + key +
                       "' is missing; add the size of the images");
  const std::string type =
      file.has("Camera.type") ? file.as<std::string>("Camera.type") : "PinHole";
  std::string model = type == "Rectified" ? "none" : "";
  std::vector<double> d = {optional("k1"), optional("k2"), optional("p1"), optional("p2"),
                           optional("k3")};
  if (type == "Rectified") {
    d.clear();
  } else if (type == "KannalaBrandt8") {
    model = "fisheye";
    d = {optional("k1"), optional("k2"), optional("k3"), optional("k4")};
  } else if (type != "PinHole") {
    throw InputError(file.origin() + ": Camera.type '" + type +
                     "' is not supported (PinHole, KannalaBrandt8, Rectified)");
  }
  return cameraOf(file.as<int>("Camera.width"), file.as<int>("Camera.height"),
                  {number("fx"), number("fy"), number("cx"), number("cy")}, model, d,
                  file.origin());
}

/// VINS-Fusion (camodocal).
CameraModel fromModelType(const Keys& file) {
  const auto type = file.as<std::string>("model_type");
  const Keys projection = file.below("projection_parameters");
  const int width = file.as<int>("image_width"), height = file.as<int>("image_height");
  if (type == "KANNALA_BRANDT")
    return cameraOf(width, height,
                    {projection.number("mu"), projection.number("mv"), projection.number("u0"),
                     projection.number("v0")},
                    "fisheye",
                    {projection.number("k2"), projection.number("k3"), projection.number("k4"),
                     projection.number("k5")},
                    file.origin());
  if (type != "PINHOLE")
    throw InputError(file.origin() + ": model_type '" + type +
                     "' is not supported (PINHOLE, KANNALA_BRANDT)");
  const Keys distortion = file.below("distortion_parameters");
  return cameraOf(width, height,
                  {projection.number("fx"), projection.number("fy"), projection.number("cx"),
                   projection.number("cy")},
                  "",
                  {distortion.number("k1"), distortion.number("k2"), distortion.number("p1"),
                   distortion.number("p2")},
                  file.origin());
}

/// Kalibr's camchain. @param name of the camera; empty: there must be only one.
CameraModel fromChain(const Keys& file, const std::string& path, const std::string& name) {
  std::string names, only;
  size_t count = 0;
  for (const std::string& camera : file.maps()) {
    if (!file.below(camera.c_str()).has("intrinsics")) continue;
    names += (names.empty() ? "" : ", ") + camera;
    only = camera;
    ++count;
    if (camera == name) return fromIntrinsics(file.below(camera.c_str()));
  }
  if (count == 0)
    throw InputError(file.origin() +
                     ": no calibration of a camera: key 'camera_matrix' is missing; " + kFormats);
  if (!name.empty())
    throw InputError(file.origin() + ": there is no camera '" + name + "' (" + names + ")");
  if (count > 1)
    throw InputError(file.origin() + ": there are several cameras (" + names + "); choose one as " +
                     path + ":" + only);
  return fromIntrinsics(file.below(only.c_str()));
}

}  // namespace

CameraModel CameraModel::fromYamlFile(const std::string& file) {
  std::string path = file, name;
  if (const auto colon = file.rfind(':');
      colon != std::string::npos && !std::filesystem::exists(file)) {
    path = file.substr(0, colon);
    name = file.substr(colon + 1);
  }
  const Keys keys(loadYamlFile(path), path);
  if (!name.empty()) return fromChain(keys, path, name);
  if (keys.has("camera_matrix")) return fromCameraMatrix(keys);
  if (keys.has("intrinsics")) return fromIntrinsics(keys);
  if (keys.has("model_type")) return fromModelType(keys);
  for (const std::string prefix : {"Camera1.", "Camera."})
    if (keys.has((prefix + "fx").c_str())) return fromOrbSlam(keys, prefix);
  return fromChain(keys, path, name);
}

}  // namespace edge_mcl
