#include "apps/recordings/recording_options.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/recordings/sequence.h"
#include "edge_mcl/localization/map_factory.h"
#include "edge_mcl/localization/recorded/moved_input.h"
#include "edge_mcl/localization/recorded/sequence_input.h"
#include "edge_mcl/localization/recorded/video_input.h"
#include "edge_mcl/mrpt_plugins/rawlog_input.h"
#ifdef EDGE_MCL_HAS_ROS
#include "edge_mcl/nodes/bags/bag_reader.h"
#endif

namespace edge_mcl {

void RecordingOptions::addTo(CLI::App* c) {
  c->add_option_function<std::vector<std::string>>(
       "sequence",
       [this](const std::vector<std::string>& names) {
         parts = names;
         recording = names.front();
       },
       "recording: a directory with rgb.txt, camera.yaml and sequence.yaml (see "
       "docs/sequences.md), a folder of EuRoC or KITTI or of photographs, a video, a ROS bag (see "
       "docs/ros.md) or all parts of one, or an MRPT rawlog")
      ->required()
      ->expected(1, 10000);
  c->add_option("--model", model,
                "model file; default: SEQUENCE/model.obj; required for other recordings");
  CLI::Option* initial_spread =
      c->add_option("--initial-std", initial_std,
                    "standard deviation of the initial pose per axis, as metres,degrees; default: "
                    "that of the recording, or 0.1,3 when it has none");
  CLI::Option* everywhere =
      c->add_flag("--global", global,
                  "search for the pose in the whole model; default: start at the initial pose")
          ->excludes(initial_spread);
  CLI::Option* upright =
      c->add_option("--up", up,
                    "search for the pose in the whole model, with the upward direction in the "
                    "first image: x,y,z in the axes of the camera (in a bag or rawlog: of the "
                    "base), e.g. 0,-1,0 for a level camera; default: not known")
          ->excludes(initial_spread);
  c->add_option(
      "--topics", topics,
      "names of topics and frames in a bag, e.g. image=/cam/image_raw,mask=,odom_frame=odom "
      "(see docs/ros.md); default: the names that `edge-mcl bag` writes");
  c->add_option("--initial-pose", initial_pose,
                "initial pose of the base as x,y,z,roll,pitch,yaw, in metres and degrees; in a "
                "directory or video of the camera (x right, y down, z ahead); default: the initial "
                "pose of the recording")
      ->excludes(everywhere)
      ->excludes(upright);
  c->add_option("--camera", camera,
                "file with the calibration (of ROS camera_calibration, OpenCV, Kalibr, EuRoC, "
                "ORB-SLAM or VINS); default: the calibration in the recording");
  c->add_flag("--depth", depth,
              "use the depth images as well: sets likelihood.cues to both, unless it is depth");
  CLI::Option* without_masks = c->add_flag(
      "--no-mask", no_mask, "use no masks; default: the masks of the recording are used");
  c->add_option(
       "--masks", masks,
       "in place of the recording's masks: a directory with mask.txt (see `edge-mcl detect "
       "--out`; only for a sequence directory), or depth: what the depth images show in "
       "front of the model is masked (tracking.mask_by_depth)")
      ->excludes(without_masks);
  parameters.addTo(c);
}

namespace {

bool endsWith(const std::string& text, const std::string& ending) {
  return text.size() > ending.size() &&
         std::equal(ending.rbegin(), ending.rend(), text.rbegin(), [](char a, char b) {
           return a == std::tolower(static_cast<unsigned char>(b));
         });
}

/// @param what was found. @throws InputError
[[noreturn]] void refuseRos2(const std::string& recording, const std::string& what) {
  const std::string folder = std::filesystem::path(recording).parent_path().string();
  throw InputError(recording + ": " + what +
                   "; convert its folder with `pip install rosbags` and `rosbags-convert --src " +
                   (folder.empty() ? "." : folder) + " --dst ros1.bag`");
}

}  // namespace

RecordingKind kindOf(const std::string& recording) {
  std::error_code ignored;
  if (std::filesystem::is_directory(recording, ignored)) return RecordingKind::kDirectory;
  std::string head(16, '\0');
  std::ifstream in(recording, std::ios::binary);
  in.read(head.data(), static_cast<std::streamsize>(head.size()));
  if (head.rfind("#ROSBAG V", 0) == 0) return RecordingKind::kBag;
  if (head.rfind("\x89MCAP0", 0) == 0) refuseRos2(recording, "an MCAP file of ROS 2");
  if (head.rfind("SQLite format 3", 0) == 0) refuseRos2(recording, "a bag of ROS 2 (SQLite)");
  if (endsWith(recording, ".bag") || endsWith(recording, ".bag.active")) return RecordingKind::kBag;
  if (endsWith(recording, ".rawlog")) return RecordingKind::kRawlog;
  for (const char* ending : {".mp4", ".avi", ".mkv", ".mov", ".webm", ".m4v", ".mpg", ".mjpeg"})
    if (endsWith(recording, ending)) return RecordingKind::kVideo;
  return RecordingKind::kDirectory;
}

Parameters parametersOf(const RecordingOptions& options) {
  Parameters params = options.parameters.load();
  if (options.masksAreOfDepth()) params.tracking.mask_by_depth = true;
  if (options.no_mask) params.tracking.mask_by_depth = false;
  if (options.depth && params.likelihood.cues == Cues::kEdges) params.likelihood.cues = Cues::kBoth;
  return params;
}

namespace {

/// Reads "metres,degrees", e.g. "0.1,3".
/// @return metres and radians.
/// @throws ParameterError
std::pair<double, double> parseInitialStd(const std::string& text) {
  double metres = NAN, degrees = NAN;
  char rest = 0;
  if (std::sscanf(text.c_str(), "%lf,%lf%c", &metres, &degrees, &rest) != 2 || !(metres >= 0) ||
      !(degrees >= 0) || !std::isfinite(metres + degrees))
    throw ParameterError("--initial-std " + text +
                         ": must be two numbers metres,degrees that are not negative");
  return {metres, degrees * M_PI / 180};
}

/// @throws ParameterError when an option does not fit the kind of recording
void checkOptions(const RecordingOptions& o, RecordingKind kind) {
  if (kind != RecordingKind::kBag) {
    if (!o.topics.empty()) throw ParameterError("--topics needs a bag");
    if (o.parts.size() > 1)
      throw ParameterError(o.parts[1] + ": only a bag can have several parts");
  }
  if (kind != RecordingKind::kDirectory && !o.masks.empty() && !o.masksAreOfDepth())
    throw ParameterError("--masks " + o.masks + " needs a sequence directory");
}

std::optional<CameraModel> givenCamera(const RecordingOptions& o) {
  if (o.camera.empty()) return std::nullopt;
  return CameraModel::fromYamlFile(o.camera);
}

#ifdef EDGE_MCL_HAS_ROS
BagTopics parseTopics(const RecordingOptions& o) {
  BagTopics topics;
  std::map<std::string, std::string*> fields{{"image", &topics.image},
                                             {"camera_info", &topics.camera_info},
                                             {"mask", &topics.mask},
                                             {"depth", &topics.depth},
                                             {"depth_info", &topics.depth_info},
                                             {"truth", &topics.truth},
                                             {"initialpose", &topics.initial_pose},
                                             {"odometry", &topics.odometry},
                                             {"odom_frame", &topics.odom_frame},
                                             {"base_frame", &topics.base_frame},
                                             {"camera_frame", &topics.camera_frame},
                                             {"rectified", &topics.rectified}};
  std::istringstream list(o.topics);
  for (std::string entry; std::getline(list, entry, ',');) {
    const auto equals = entry.find('=');
    const auto field = fields.find(entry.substr(0, equals));
    if (equals == std::string::npos || field == fields.end())
      throw ParameterError(
          "--topics " + entry +
          ": must have the form NAME=TOPIC, where NAME is one of image, camera_info, mask, depth, "
          "depth_info, truth, "
          "initialpose, odometry, odom_frame, base_frame, camera_frame, rectified");
    *field->second = entry.substr(equals + 1);
  }
  if (topics.rectified != "auto" && topics.rectified != "true" && topics.rectified != "false")
    throw ParameterError("--topics rectified=" + topics.rectified +
                         ": must be auto, true or false");
  if (!o.usesOwnMasks()) topics.mask.clear();
  return topics;
}
#endif

PoseGaussian initialPose(const RecordingOptions& o, const std::optional<PoseGaussian>& recorded) {
  PoseGaussian pose;
  if (!o.initial_pose.empty()) {
    double v[6];
    char rest = 0;
    if (std::sscanf(o.initial_pose.c_str(), "%lf,%lf,%lf,%lf,%lf,%lf%c", &v[0], &v[1], &v[2], &v[3],
                    &v[4], &v[5], &rest) != 6)
      throw ParameterError("--initial-pose " + o.initial_pose +
                           ": must be x,y,z,roll,pitch,yaw (metres, degrees)");
    const double degree = M_PI / 180;
    pose.mean.translation() = Eigen::Vector3d(v[0], v[1], v[2]);
    pose.mean.linear() = rotationFromAngles(v[3] * degree, v[4] * degree, v[5] * degree);
  } else if (recorded) {
    pose = *recorded;
  } else {
    throw InputError(o.recording + ": the recording has no initial pose; " +
                     (kindOf(o.recording) == RecordingKind::kDirectory
                          ? "set initial_pose in its sequence.yaml, give it with --initial-pose"
                          : "give it with --initial-pose") +
                     ", or search for it with --global");
  }
  if (!o.initial_std.empty() || pose.covariance.isZero()) {
    const auto [metres, radians] = parseInitialStd(o.initial_std.empty() ? "0.1,3" : o.initial_std);
    pose.covariance.setZero();
    pose.covariance.diagonal().head<3>().setConstant(metres * metres);
    pose.covariance.diagonal().tail<3>().setConstant(radians * radians);
  }
  return pose;
}

void openDirectory(const RecordingOptions& o, const Parameters& params, bool everything,
                   OpenedRecording* opened) {
  Sequence sequence = readSequence(o.recording, o.camera);
  if (!o.masks.empty() && !o.masksAreOfDepth()) useMasks(o.masks, &sequence);
  for (const std::string& w : sequence.warnings) std::fprintf(stderr, "warning: %s\n", w.c_str());
  opened->name = sequence.name;
  opened->trajectory_pose = "T_map_camera";
  if (opened->model_file.empty()) opened->model_file = sequence.model_file;
  if (opened->model_file.empty())
    throw InputError(o.recording + ": the directory has no model.obj; name the model with --model");
  const bool needs_depth = neededImages(params) != Cues::kEdges;
  if (needs_depth && sequence.depths.empty())
    throw InputError(
        o.recording +
        ": depth asked for (--depth, or masks by depth), but the directory has no depth.txt");
  const SequenceParts parts{everything || params.likelihood.cues != Cues::kDepth, o.usesOwnMasks(),
                            everything || needs_depth};
  opened->input = std::make_unique<SequenceInput>(std::move(sequence), parts);
}

std::unique_ptr<RecordedInput> openRawlog(const RecordingOptions& o, const Parameters& params,
                                          bool everything) {
  const bool needs_depth = neededImages(params) != Cues::kEdges;
  auto rawlog = std::make_unique<RawlogInput>(o.recording, o.usesOwnMasks(),
                                              everything || needs_depth, givenCamera(o));
  if (needs_depth && rawlog->rangeCount() == 0)
    throw InputError(o.recording + ": depth asked for, but the rawlog has no range images");
  return rawlog;
}

std::unique_ptr<RecordedInput> openBag(const RecordingOptions& o, const Parameters& params,
                                       bool everything) {
#ifdef EDGE_MCL_HAS_ROS
  const bool needs_depth = neededImages(params) != Cues::kEdges;
  BagTopics topics = parseTopics(o);
  if (!everything && !needs_depth) topics.depth.clear();
  auto bag = std::make_unique<BagReader>(o.parts.empty() ? std::vector{o.recording} : o.parts,
                                         topics, givenCamera(o));
  if (needs_depth && !bag->hasDepth())
    throw InputError(o.recording + ": depth asked for, but there are no images on '" +
                     topics.depth + "'");
  return bag;
#else
  (void)params;
  (void)everything;
  throw InputError(o.recording + ": this build has no ROS, so it cannot read bags");
#endif
}

std::unique_ptr<RecordedInput> openVideo(const RecordingOptions& o, const Parameters& params) {
  if (neededImages(params) != Cues::kEdges)
    throw InputError(o.recording + ": depth asked for, but a video has no depth");
  const auto camera = givenCamera(o);
  if (!camera)
    throw InputError(o.recording + ": a video needs its calibration; name it with --camera");
  return std::make_unique<VideoInput>(o.recording, *camera);
}

void printNotes(const RecordedInput& input, const std::string& name) {
  for (const std::string& note : input.notes())
    std::fprintf(stderr, "note: %s: %s\n", name.c_str(), note.c_str());
  if (const std::string damage = input.damage(); !damage.empty())
    std::fprintf(stderr, "warning: %s\n", damage.c_str());
}

}  // namespace

std::optional<Eigen::Vector3d> parseUp(const std::string& text) {
  if (text.empty()) return std::nullopt;
  Eigen::Vector3d up;
  char rest = 0;
  if (std::sscanf(text.c_str(), "%lf,%lf,%lf%c", &up.x(), &up.y(), &up.z(), &rest) != 3 ||
      !up.allFinite() || !(up.norm() > 1e-3 && up.norm() < 1e6))
    throw ParameterError("--up " + text + ": must be a direction x,y,z");
  return up.normalized();
}

std::unique_ptr<RecordedInput> openInput(const RecordingOptions& o) {
  const RecordingKind kind = kindOf(o.recording);
  checkOptions(o, kind);
  std::unique_ptr<RecordedInput> input;
  if (kind == RecordingKind::kDirectory) {
    Sequence sequence = readSequence(o.recording, o.camera);
    for (const std::string& w : sequence.warnings) std::fprintf(stderr, "warning: %s\n", w.c_str());
    input = std::make_unique<SequenceInput>(std::move(sequence), SequenceParts{true, true, true});
  } else if (kind == RecordingKind::kRawlog) {
    input = openRawlog(o, {}, true);
  } else if (kind == RecordingKind::kVideo) {
    input = openVideo(o, {});
  } else {
    input = openBag(o, {}, true);
  }
  printNotes(*input, o.recording);
  return input;
}

OpenedRecording openRecording(const RecordingOptions& o, bool everything) {
  const Parameters params = parametersOf(o);
  OpenedRecording opened;
  opened.name = o.recording;
  opened.model_file = o.model;
  const RecordingKind kind = kindOf(o.recording);
  checkOptions(o, kind);
  if (kind == RecordingKind::kDirectory) {
    openDirectory(o, params, everything, &opened);
  } else {
    if (o.model.empty()) throw InputError(o.recording + ": name the model with --model");
    if (kind == RecordingKind::kRawlog)
      opened.input = openRawlog(o, params, everything);
    else if (kind == RecordingKind::kVideo)
      opened.input = openVideo(o, params);
    else
      opened.input = openBag(o, params, everything);
    if (kind == RecordingKind::kVideo) opened.trajectory_pose = "T_map_camera";
  }
  printNotes(*opened.input, o.recording);
  opened.start.up_base = parseUp(o.up);
  if (!o.global && !opened.start.up_base)
    opened.start.pose = initialPose(o, opened.input->initialPose());
  opened.map = makeMap(opened.model_file, params);
  opened.origin = opened.map->mesh().origin;
  if (params.map.absolute_poses && !opened.origin.isZero()) {
    if (opened.start.pose) opened.start.pose->mean.translation() -= opened.origin;
    opened.input = std::make_unique<MovedInput>(std::move(opened.input), opened.origin);
  } else {
    opened.origin.setZero();
  }
  if (opened.start.pose) {
    // Differences of national coordinates have a rounding error. With whole micrometres a flight
    // has the same poses wherever its building stands.
    auto position = opened.start.pose->mean.translation();
    position = (position * 1e6).array().round().matrix() / 1e6;
  }
  for (const std::string& w : opened.map->mesh().report.warnings)
    std::fprintf(stderr, "warning: %s: %s\n", opened.model_file.c_str(), w.c_str());
  return opened;
}

}  // namespace edge_mcl
