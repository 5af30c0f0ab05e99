#include "edge_mcl/core/recordings/sequence.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/base/yaml_file.h"
#include "edge_mcl/core/depth/depth_points.h"
#include "edge_mcl/core/recordings/foreign_folders.h"

namespace edge_mcl {

namespace fs = std::filesystem;

namespace {

constexpr double kSameTime = 0.005;  // seconds

template <class Entry>
const Entry* nearestInTime(const std::vector<Entry>& sorted, double time,
                           double tolerance = kSameTime) {
  auto it = std::lower_bound(sorted.begin(), sorted.end(), time,
                             [](const Entry& e, double t) { return e.time < t; });
  const Entry* best = nullptr;
  if (it != sorted.end()) best = &*it;
  if (it != sorted.begin() &&
      (!best || std::abs((it - 1)->time - time) < std::abs(best->time - time)))
    best = &*(it - 1);
  return best && std::abs(best->time - time) <= tolerance ? best : nullptr;
}

Pose poseFromList(const std::vector<double>& v, const std::string& where) {
  if (v.size() != 7) throw InputError(where + " must have 7 numbers: tx ty tz qx qy qz qw");
  for (double x : v)
    if (!std::isfinite(x)) throw InputError(where + " has a number that is not finite");
  const Eigen::Quaterniond q(v[6], v[3], v[4], v[5]);
  if (std::abs(q.norm() - 1) > 0.01)
    throw InputError(where + ": the quaternion must have unit length");
  Pose pose = Pose::Identity();
  pose.linear() = q.normalized().toRotationMatrix();
  pose.translation() = Eigen::Vector3d(v[0], v[1], v[2]);
  return pose;
}

void readDescription(const std::string& file, Sequence* sequence) {
  const YAML::Node root = loadYamlFile(file);
  try {
    if (!root.IsMap()) throw InputError(file + ": not a YAML map");
    if (root["name"]) sequence->name = root["name"].as<std::string>();
    if (root["initial_pose"])
      sequence->initial_pose =
          poseFromList(root["initial_pose"].as<std::vector<double>>(), file + ": initial_pose");
    if (root["depth_scale"]) {
      sequence->depth_scale = root["depth_scale"].as<double>();
      if (!std::isfinite(sequence->depth_scale) || !(sequence->depth_scale > 0))
        throw InputError(file + ": depth_scale must be positive");
    }
    if (root["initial_std"]) {
      const auto s = root["initial_std"].as<std::vector<double>>();
      if (s.size() != 2 || !(s[0] >= 0) || !(s[1] >= 0) || !std::isfinite(s[0] + s[1]))
        throw InputError(file + ": initial_std must be two numbers (m, rad), each zero or more");
      sequence->initial_std_position = s[0];
      sequence->initial_std_angle = s[1];
    }
  } catch (const YAML::Exception& e) {
    throw InputError(file + ": " + e.what());
  }
}

/// Files of a list, with their directory, in the order of time.
std::vector<StampedFile> sortedList(const fs::path& directory, const std::string& list) {
  std::vector<StampedFile> files = readFileList((directory / list).string());
  for (StampedFile& entry : files) entry.file = (directory / entry.file).string();
  std::stable_sort(files.begin(), files.end(),
                   [](const StampedFile& a, const StampedFile& b) { return a.time < b.time; });
  return files;
}

/// Odometry at a time. A pose recorded at this time is returned as it is. Otherwise the pose is
/// interpolated between its neighbours, or extrapolated a little beyond the ends of the list. If
/// that is not possible, it is the nearest pose within 5 ms.
std::optional<Pose> odometryAt(const Trajectory& odometry, double time) {
  constexpr double kSameStamp = 1e-6, kLargestGap = 0.5, kBeyond = 0.05;  // s
  const StampedPose* nearest = nearestInTime(odometry, time);
  if (nearest && std::abs(nearest->time - time) <= kSameStamp) return nearest->pose;
  if (odometry.size() >= 2) {
    const auto after = std::lower_bound(odometry.begin() + 1, odometry.end() - 1, time,
                                        [](const StampedPose& p, double t) { return p.time < t; });
    const StampedPose &a = *(after - 1), &b = *after;
    if (b.time - a.time <= kLargestGap && time >= a.time - kBeyond && time <= b.time + kBeyond) {
      const double share = (time - a.time) / (b.time - a.time);
      return normalized(a.pose * expSe3(share * logSe3(a.pose.inverse() * b.pose)));
    }
  }
  if (nearest) return nearest->pose;
  return std::nullopt;
}

std::string missingMasks(size_t count, size_t images) {
  return "mask.txt: none for " + std::to_string(count) + " of " + std::to_string(images) +
         " images (within 5 ms)";
}

/// Warns of lists whose times do not fit the images, because this is usually a mistake.
void warnOfWhatDoesNotMatch(bool has_masks, const std::string& directory, Sequence* sequence) {
  size_t odometry = 0, masks = 0, depths = 0;
  for (const SequenceFrame& f : sequence->frames) {
    odometry += f.odometry ? 1 : 0;
    masks += f.mask_file.empty() ? 0 : 1;
    depths += f.depth_file.empty() ? 0 : 1;
  }
  const auto warn = [&](const std::string& text) {
    sequence->warnings.push_back(directory + "/" + text);
  };
  const size_t images = sequence->frames.size();
  if (sequence->has_odometry && odometry < images)
    warn("odometry.txt: none for " + std::to_string(images - odometry) + " of " +
         std::to_string(images) + " images (no pose near their time)");
  if (has_masks && masks == 0) warn("mask.txt: no mask has the time of an image (within 5 ms)");
  if (masks > 0 && masks < images) warn(missingMasks(images - masks, images));
  if (!sequence->depths.empty() && depths == 0)
    warn("depth.txt: no depth image has the time of an image (within 25 ms)");
}

}  // namespace

const Pose& startOf(const Sequence& sequence) {
  if (!sequence.initial_pose)
    throw InputError(sequence.directory + "/sequence.yaml: initial_pose is missing");
  return *sequence.initial_pose;
}

void useMasks(const std::string& directory, Sequence* sequence) {
  const std::vector<StampedFile> masks = sortedList(directory, "mask.txt");
  size_t count = 0;
  for (SequenceFrame& frame : sequence->frames) {
    const StampedFile* mask = nearestInTime(masks, frame.time);
    frame.mask_file = mask ? mask->file : "";
    if (mask) ++count;
  }
  if (count == 0)
    throw InputError(directory + "/mask.txt: no mask has the time of an image of " +
                     sequence->directory);
  const size_t images = sequence->frames.size();
  if (count < images)
    sequence->warnings.push_back(directory + "/" + missingMasks(images - count, images));
}

void fillFrames(const SequenceLists& lists, Sequence* sequence) {
  for (const StampedFile& entry : lists.images) {
    if (!sequence->frames.empty() && entry.time <= sequence->frames.back().time) {
      sequence->warnings.push_back(lists.origin + ": time goes back at " + entry.time_text +
                                   ", the image is left out");
      continue;
    }
    SequenceFrame frame;
    frame.time = entry.time;
    frame.time_text = entry.time_text;
    frame.image_file = entry.file;
    if (const StampedFile* mask = nearestInTime(lists.masks, entry.time))
      frame.mask_file = mask->file;
    if (const StampedFile* d = nearestInTime(sequence->depths, entry.time, kDepthWindow))
      frame.depth_file = d->file;
    frame.odometry = odometryAt(lists.odometry, entry.time);
    if (const StampedPose* p = nearestInTime(lists.truth, entry.time)) frame.ground_truth = p->pose;
    sequence->frames.push_back(std::move(frame));
  }
  if (sequence->frames.empty()) throw InputError(lists.origin + ": no images listed");
  sequence->has_odometry = !lists.odometry.empty();
  warnOfWhatDoesNotMatch(!lists.masks.empty(), sequence->directory, sequence);
}

Sequence readSequence(const std::string& directory, const std::string& camera_file) {
  const fs::path root(directory);
  std::error_code ignored;
  if (!fs::is_directory(root, ignored)) throw InputError(directory + ": no such directory");
  const auto inside = [&](const std::string& name) { return (root / name).string(); };

  Sequence sequence;
  sequence.directory = directory;
  const fs::path full = fs::absolute(root).lexically_normal();
  sequence.name = (full.has_filename() ? full : full.parent_path()).filename().string();
  if (fs::exists(inside("sequence.yaml"), ignored))
    readDescription(inside("sequence.yaml"), &sequence);
  if (fs::exists(inside("model.obj"), ignored)) sequence.model_file = inside("model.obj");
  if (readForeignFolder(camera_file, &sequence)) return sequence;

  sequence.camera =
      CameraModel::fromYamlFile(camera_file.empty() ? inside("camera.yaml") : camera_file);
  SequenceLists lists;
  lists.origin = inside("rgb.txt");
  if (fs::exists(inside("mask.txt"), ignored)) lists.masks = sortedList(root, "mask.txt");
  if (fs::exists(inside("depth.txt"), ignored)) sequence.depths = sortedList(root, "depth.txt");
  if (fs::exists(inside("odometry.txt"), ignored))
    lists.odometry = readTrajectory(inside("odometry.txt"));
  if (fs::exists(inside("groundtruth.txt"), ignored))
    lists.truth = readTrajectory(inside("groundtruth.txt"));
  lists.images = readFileList(lists.origin);
  for (StampedFile& image : lists.images) image.file = inside(image.file);
  fillFrames(lists, &sequence);
  return sequence;
}

cv::Mat readImage(const std::string& file, const CameraModel& camera) {
  cv::Mat image;
  try {
    image = cv::imread(file, cv::IMREAD_UNCHANGED);
  } catch (const cv::Exception& e) {
    throw InputError(file + ": cannot be decoded: " + e.err);
  }
  if (image.empty()) throw InputError(file + ": missing or not a readable image");
  if (image.cols != camera.width || image.rows != camera.height)
    throw InputError(file + ": " + std::to_string(image.cols) + "x" + std::to_string(image.rows) +
                     " pixels, the calibration says " + std::to_string(camera.width) + "x" +
                     std::to_string(camera.height));
  return image;
}

cv::Mat readMask(const std::string& file, const CameraModel& camera) {
  std::vector<cv::Mat> channels;
  cv::split(readImage(file, camera), channels);
  const bool has_alpha = channels.size() == 2 || channels.size() == 4;
  if (has_alpha) channels.pop_back();
  cv::Mat mask = channels.front() != 0;
  for (const cv::Mat& channel : channels) mask |= channel != 0;
  return mask;
}

cv::Mat readDepth(const std::string& file, const CameraModel& camera) {
  cv::Mat depth = readImage(file, camera);
  if (depth.type() != CV_16UC1)
    throw InputError(file + ": a depth image must have one channel of 16 bits");
  return depth;
}

}  // namespace edge_mcl
