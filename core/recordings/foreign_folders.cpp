#include "edge_mcl/core/recordings/foreign_folders.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <sstream>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/base/yaml_file.h"

namespace edge_mcl {

namespace fs = std::filesystem;

namespace {

bool isThere(const fs::path& path) {
  std::error_code ignored;
  return fs::exists(path, ignored);
}

/// T_BS of EuRoC's sensor.yaml: the pose of the sensor in the body.
Pose mountingIn(const std::string& file) {
  const YAML::Node root = loadYamlFile(file);
  Pose pose = Pose::Identity();
  try {
    if (!root.IsMap() || !root["T_BS"]) return pose;
    const auto v = root["T_BS"]["data"].as<std::vector<double>>();
    if (v.size() != 16) throw InputError(file + ": T_BS must have 16 numbers");
    const Eigen::Matrix<double, 4, 4, Eigen::RowMajor> matrix(v.data());
    pose.matrix().topRows<3>() = matrix.topRows<3>();
    constexpr double kRounding = 1e-3;
    const Eigen::Matrix3d square = pose.linear() * pose.linear().transpose();
    if (!matrix.allFinite() || !square.isIdentity(kRounding) || pose.linear().determinant() < 0)
      throw InputError(file + ": T_BS is not a rotation and a shift");
  } catch (const YAML::Exception& e) {
    throw InputError(file + ": T_BS: " + e.what());
  }
  return pose;
}

/// @param camera the folder cam0. @return whether it is EuRoC's
bool readEuroc(const fs::path& camera, const std::string& camera_file, Sequence* sequence) {
  if (!isThere(camera / "data.csv")) return false;
  const std::string sensor = (camera / "sensor.yaml").string();
  if (camera_file.empty() && !isThere(sensor))
    throw InputError(sensor + ": is missing; name the calibration with --camera");
  sequence->camera = CameraModel::fromYamlFile(camera_file.empty() ? sensor : camera_file);
  SequenceLists lists;
  lists.origin = (camera / "data.csv").string();
  lists.images = readFileList(lists.origin);
  for (StampedFile& image : lists.images) image.file = (camera / "data" / image.file).string();
  for (const char* name : {"state_groundtruth_estimate0", "vicon0", "mocap0"}) {
    const fs::path truth = camera.parent_path() / name / "data.csv";
    if (!isThere(truth) || !isThere(sensor)) continue;
    lists.truth = readTrajectory(truth.string());
    // The truth is that of the marker, which has a place on the body as well.
    const std::string marker = (camera.parent_path() / name / "sensor.yaml").string();
    const Pose T_body_marker = isThere(marker) ? mountingIn(marker) : Pose::Identity();
    const Pose T_marker_camera = T_body_marker.inverse() * mountingIn(sensor);
    for (StampedPose& pose : lists.truth) pose.pose = pose.pose * T_marker_camera;
    break;
  }
  fillFrames(lists, sequence);
  return true;
}

/// Camera of a line "P0: ..." with a projection of twelve numbers; KITTI's images are rectified.
CameraModel kittiCamera(const fs::path& calibration, const std::string& name, cv::Size size) {
  std::ifstream in(calibration);
  for (std::string line; std::getline(in, line);) {
    if (line.rfind(name + ":", 0) != 0) continue;
    std::istringstream numbers(line.substr(name.size() + 1));
    std::array<double, 12> p{};
    for (double& v : p) numbers >> v;
    if (!numbers) break;
    return CameraModel::fromFields(size.width, size.height,
                                   {p[0], p[1], p[2], p[4], p[5], p[6], p[8], p[9], p[10]}, "none",
                                   nullptr, 0, calibration.string());
  }
  throw InputError(calibration.string() + ": there is no line '" + name + ": ' with 12 numbers");
}

bool isImage(const fs::path& file) {
  std::string ending = file.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  constexpr std::array<const char*, 8> kEndings = {".png", ".jpg",  ".jpeg", ".bmp",
                                                   ".tif", ".tiff", ".pgm",  ".ppm"};
  return std::find(kEndings.begin(), kEndings.end(), ending) != kEndings.end();
}

/// Splits a name into text and numbers, so that image_9 comes before image_10.
bool comesBefore(const std::string& a, const std::string& b) {
  size_t i = 0, k = 0;
  const auto isDigit = [](char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; };
  while (i < a.size() && k < b.size()) {
    if (!isDigit(a[i]) || !isDigit(b[k])) {
      if (a[i] != b[k]) return a[i] < b[k];
      ++i;
      ++k;
      continue;
    }
    const auto number = [&](const std::string& text, size_t* at) {
      const size_t begin = *at;
      while (*at < text.size() && isDigit(text[*at])) ++*at;
      const std::string digits = text.substr(begin, *at - begin);
      const auto first = digits.find_first_not_of('0');
      return first == std::string::npos ? std::string() : digits.substr(first);
    };
    const std::string first = number(a, &i), second = number(b, &k);
    if (first.size() != second.size()) return first.size() < second.size();
    if (first != second) return first < second;
  }
  return a.size() - i < b.size() - k;
}

std::vector<std::string> imagesIn(const fs::path& folder) {
  std::vector<std::string> names;
  std::error_code ignored;
  for (const auto& entry : fs::directory_iterator(folder, ignored))
    if (entry.is_regular_file(ignored) && isImage(entry.path()))
      names.push_back(entry.path().filename().string());
  std::sort(names.begin(), names.end(), comesBefore);
  return names;
}

cv::Size sizeOf(const fs::path& image) {
  const cv::Mat first = cv::imread(image.string(), cv::IMREAD_UNCHANGED);
  if (first.empty()) throw InputError(image.string() + ": missing or not a readable image");
  return first.size();
}

bool readKitti(const fs::path& root, const std::string& camera_file, Sequence* sequence) {
  constexpr size_t kLongest = 9;  // digits of a counter
  if (!isThere(root / "times.txt")) return false;
  for (const char* number : {"0", "2"}) {
    const fs::path folder = root / (std::string("image_") + number);
    const std::vector<std::string> names = imagesIn(folder);
    if (names.empty()) continue;
    sequence->camera = camera_file.empty()
                           ? kittiCamera(root / "calib.txt", std::string("P") + number,
                                         sizeOf(folder / names.front()))
                           : CameraModel::fromYamlFile(camera_file);
    SequenceLists lists;
    lists.origin = (root / "times.txt").string();
    std::ifstream in(lists.origin);
    std::vector<std::string> times;
    for (std::string text; in >> text;) times.push_back(text);
    for (size_t i = 0; i < names.size(); ++i) {
      // Image 000012 belongs to line 12, even when another image is missing.
      const std::string stem = fs::path(names[i]).stem().string();
      const bool is_number = stem.find_first_not_of("0123456789") == std::string::npos;
      const size_t line = is_number && stem.size() < kLongest ? std::stoul(stem) : i;
      if (line >= times.size())
        throw InputError(lists.origin + ": has no line for the image " + names[i]);
      const double time = stampIn(&times[line], lists.origin + ":" + std::to_string(line + 1));
      lists.images.push_back({time, times[line], (folder / names[i]).string()});
    }
    fillFrames(lists, sequence);
    return true;
  }
  return false;
}

/// Whether all names are times since 1970, between 2001 and 2096. Counters are smaller, and dates
/// as one number (20240101120000) are none.
bool areStamps(const std::vector<std::string>& names) {
  constexpr size_t kFewest = 10;                    // digits of such a time in seconds
  constexpr double kEarliest = 1e9, kLatest = 4e9;  // s
  return std::all_of(names.begin(), names.end(), [](const std::string& name) {
    std::string stem = fs::path(name).stem().string();
    if (stem.size() < kFewest || stem.find_first_not_of("0123456789.") != std::string::npos)
      return false;
    try {
      const double time = stampIn(&stem, name);
      return time > kEarliest && time < kLatest;
    } catch (const InputError&) {
      return false;
    }
  });
}

bool readPhotographs(const fs::path& root, const std::string& camera_file, Sequence* sequence) {
  const std::vector<std::string> names = imagesIn(root);
  if (names.empty()) return false;
  const std::string own = (root / "camera.yaml").string();
  if (camera_file.empty() && !isThere(own))
    throw InputError(root.string() +
                     ": a folder of images needs its calibration; name it with --camera");
  sequence->camera = CameraModel::fromYamlFile(camera_file.empty() ? own : camera_file);
  SequenceLists lists;
  lists.origin = root.string();
  constexpr double kRate = 10;  // Hz, assumed
  const bool has_times = areStamps(names);
  for (size_t i = 0; i < names.size(); ++i) {
    StampedFile image;
    image.file = (root / names[i]).string();
    image.time_text = fs::path(names[i]).stem().string();
    if (has_times) {
      image.time = stampIn(&image.time_text, image.file);
    } else {
      image.time = static_cast<double>(i) / kRate;
      char text[32];
      std::snprintf(text, sizeof text, "%.6f", image.time);
      image.time_text = text;
    }
    lists.images.push_back(std::move(image));
  }
  if (!has_times)
    sequence->warnings.push_back(root.string() +
                                 ": the times of the images are not known; ten images per second "
                                 "are assumed");
  if (isThere(root / "groundtruth.txt"))
    lists.truth = readTrajectory((root / "groundtruth.txt").string());
  fillFrames(lists, sequence);
  return true;
}

}  // namespace

bool readForeignFolder(const std::string& camera_file, Sequence* sequence) {
  const fs::path root(sequence->directory);
  if (isThere(root / "rgb.txt")) return false;
  if (isThere(root / "metadata.yaml")) {
    std::ifstream in(root / "metadata.yaml");
    std::string head;
    std::getline(in, head);
    if (head.find("rosbag2") != std::string::npos)
      throw InputError(root.string() +
                       ": a bag of ROS 2; convert it with `pip install rosbags` and "
                       "`rosbags-convert --src " +
                       root.string() + " --dst ros1.bag`");
  }
  for (const fs::path& camera : {root / "mav0" / "cam0", root / "cam0", root})
    if (readEuroc(camera, camera_file, sequence)) return true;
  if (readKitti(root, camera_file, sequence) || readPhotographs(root, camera_file, sequence))
    return true;
  if (isThere(root / "camera.yaml")) return false;  // its list is missing, which is told
  throw InputError(
      root.string() +
      ": neither a sequence (no rgb.txt) nor a folder of EuRoC (mav0/cam0/data.csv), of "
      "KITTI (image_0, times.txt) or of images");
}

}  // namespace edge_mcl
