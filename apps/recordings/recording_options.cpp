#include "apps/recordings/recording_options.h"

#include <cmath>
#include <cstdio>
#include <map>
#include <sstream>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/recordings/sequence.h"
#include "edge_mcl/localization/backend_choice.h"
#include "edge_mcl/localization/recorded/sequence_input.h"
#include "edge_mcl/mrpt_plugins/rawlog_input.h"
#ifdef EDGE_MCL_HAS_ROS
#include <rosbag/bag.h>
#include <rosbag/view.h>

#include "edge_mcl/nodes/bags/bag_reader.h"
#endif

namespace edge_mcl {

void RecordingOptions::addTo(CLI::App* c) {
  c->add_option("sequence", recording,
                "directory with rgb.txt, camera.yaml, sequence.yaml (see docs/sequences.md), a bag "
                "(see docs/ros.md) or a rawlog")
      ->required();
  c->add_option("--model", model, "model file, if not SEQUENCE/model.obj");
  CLI::Option* initial_spread = c->add_option("--initial-std", initial_std,
                                              "spread of the first particles as metres,degrees");
  CLI::Option* everywhere =
      c->add_flag("--global", global,
                  "do not begin at the initial pose but look for the camera in the whole model")
          ->excludes(initial_spread);
  CLI::Option* upright =
      c->add_option("--up", up,
                    "the same, knowing which way is up in the first image: x,y,z in the axes of "
                    "the camera (of a bag or rawlog: of the base), e.g. 0,-1,0 for a level camera")
          ->excludes(initial_spread);
  c->add_option("--topics", topics,
                "of a bag: image=/cam/image_raw,camera_info=...,mask=...,odom_frame=odom,...");
  c->add_option("--initial-pose", initial_pose,
                "of a rawlog, or of a bag without initialpose: x,y,z,roll,pitch,yaw of the base; "
                "metres, degrees")
      ->excludes(everywhere)
      ->excludes(upright);
  c->add_option(
      "--camera", camera,
      "calibration (YAML of camera_calibration) for images of a rawlog that have none, as "
      "MRPT's rosbag2rawlog writes them");
  c->add_flag("--depth", depth,
              "use the depth images, too (likelihood.cues = both, unless it says depth)");
  CLI::Option* without_masks =
      c->add_flag("--no-mask", no_mask, "do not use the masks of the recording");
  c->add_option("--masks", masks,
                "directory with mask.txt (see `edge-mcl detect --out`) to use instead")
      ->excludes(without_masks);
  parameters.addTo(c);
}

RecordingKind kindOf(const std::string& recording) {
  const auto endsWith = [&](const std::string& ending) {
    return recording.size() > ending.size() &&
           recording.compare(recording.size() - ending.size(), ending.size(), ending) == 0;
  };
  if (endsWith(".bag")) return RecordingKind::kBag;
  if (endsWith(".rawlog")) return RecordingKind::kRawlog;
  return RecordingKind::kDirectory;
}

Parameters parametersOf(const RecordingOptions& options) {
  Parameters params = options.parameters.load();
  if (options.depth && params.likelihood.cues == Cues::kEdges) params.likelihood.cues = Cues::kBoth;
  return params;
}

std::pair<double, double> parseInitialStd(const std::string& text) {
  double metres = NAN, degrees = NAN;
  char rest = 0;
  if (std::sscanf(text.c_str(), "%lf,%lf%c", &metres, &degrees, &rest) != 2 || !(metres >= 0) ||
      !(degrees >= 0) || !std::isfinite(metres + degrees))
    throw ParameterError("--initial-std " + text + ": two numbers expected, metres,degrees");
  return {metres, degrees * M_PI / 180};
}

std::optional<Eigen::Vector3d> parseUp(const std::string& text) {
  if (text.empty()) return std::nullopt;
  Eigen::Vector3d up;
  char rest = 0;
  if (std::sscanf(text.c_str(), "%lf,%lf,%lf%c", &up.x(), &up.y(), &up.z(), &rest) != 3 ||
      !up.allFinite() || up.norm() < 1e-3)
    throw ParameterError("--up " + text + ": a direction x,y,z expected");
  return up.normalized();
}

void checkOptionsOfDirectory(const RecordingOptions& o) {
  if (!o.topics.empty() || !o.initial_pose.empty())
    throw ParameterError("--topics and --initial-pose belong to a bag or rawlog");
  if (!o.camera.empty()) throw ParameterError("--camera belongs to a rawlog");
}

void sayThatNoPoseWasFound(const std::string& recording) {
  std::fprintf(stderr, "warning: %s: no pose was found; the trajectory is empty\n",
               recording.c_str());
}

namespace {

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
                                             {"base_frame", &topics.base_frame}};
  std::istringstream list(o.topics);
  for (std::string entry; std::getline(list, entry, ',');) {
    const auto equals = entry.find('=');
    const auto field = fields.find(entry.substr(0, equals));
    if (equals == std::string::npos || field == fields.end())
      throw ParameterError("--topics " + entry +
                           ": NAME=TOPIC expected, NAME one of image, camera_info, mask, depth, "
                           "depth_info, truth, "
                           "initialpose, odometry, odom_frame, base_frame");
    *field->second = entry.substr(equals + 1);
  }
  if (o.no_mask) topics.mask.clear();
  return topics;
}

bool hasMessages(const std::string& file, const std::string& topic) {
  const rosbag::Bag bag(file);
  return rosbag::View(bag, rosbag::TopicQuery(topic)).size() > 0;
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
                           ": x,y,z,roll,pitch,yaw expected (metres, degrees)");
    const double degree = M_PI / 180;
    pose.mean.translation() = Eigen::Vector3d(v[0], v[1], v[2]);
    pose.mean.linear() = rotationFromAngles(v[3] * degree, v[4] * degree, v[5] * degree);
  } else if (recorded) {
    pose = *recorded;
  } else {
    throw InputError(o.recording + ": no initial pose in it; give one " +
                     (kindOf(o.recording) == RecordingKind::kDirectory ? "in its sequence.yaml"
                                                                       : "with --initial-pose") +
                     ", or look for it with --global");
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
  checkOptionsOfDirectory(o);
  Sequence sequence = readSequence(o.recording);
  if (!o.masks.empty()) useMasks(o.masks, &sequence);
  for (const std::string& w : sequence.warnings) std::fprintf(stderr, "warning: %s\n", w.c_str());
  opened->name = sequence.name;
  if (opened->model_file.empty()) opened->model_file = sequence.model_file;
  if (opened->model_file.empty())
    throw InputError(o.recording + ": no model.obj in it; name the model with --model");
  if (params.likelihood.cues != Cues::kEdges && sequence.depths.empty())
    throw InputError(o.recording + ": depth asked for, but there is no depth.txt in it");
  const SequenceParts parts{everything || params.likelihood.cues != Cues::kDepth, !o.no_mask,
                            everything || params.likelihood.cues != Cues::kEdges};
  opened->input = std::make_unique<SequenceInput>(std::move(sequence), parts);
}

}  // namespace

OpenedRecording openRecording(const RecordingOptions& o, bool everything) {
  const Parameters params = parametersOf(o);
  const bool needs_depth = params.likelihood.cues != Cues::kEdges;
  const bool depths = everything || needs_depth;
  OpenedRecording opened;
  opened.name = o.recording;
  opened.model_file = o.model;
  const RecordingKind kind = kindOf(o.recording);
  if (!o.camera.empty() && kind != RecordingKind::kRawlog)
    throw ParameterError("--camera belongs to a rawlog");
  if (kind == RecordingKind::kDirectory) {
    openDirectory(o, params, everything, &opened);
  } else {
    if (!o.masks.empty()) throw ParameterError("--masks belongs to a directory");
    if (o.model.empty()) throw InputError(o.recording + ": name the model with --model");
    if (kind == RecordingKind::kRawlog) {
      if (!o.topics.empty()) throw ParameterError("--topics belongs to a bag");
      std::optional<CameraModel> camera;
      if (!o.camera.empty()) camera = CameraModel::fromYamlFile(o.camera);
      auto rawlog = std::make_unique<RawlogInput>(o.recording, !o.no_mask, depths, camera);
      if (needs_depth && rawlog->rangeCount() == 0)
        throw InputError(o.recording + ": depth asked for, but there are no range images in it");
      opened.input = std::move(rawlog);
    } else {
#ifdef EDGE_MCL_HAS_ROS
      BagTopics topics = parseTopics(o);
      if (!depths) topics.depth.clear();
      opened.input = std::make_unique<BagReader>(o.recording, topics);
      if (needs_depth && !hasMessages(o.recording, topics.depth))
        throw InputError(o.recording + ": depth asked for, but there are no images on '" +
                         topics.depth + "'");
#else
      throw InputError(o.recording + ": this build has no ROS, so it reads no bags");
#endif
    }
  }
  if (const std::string damage = opened.input->damage(); !damage.empty())
    std::fprintf(stderr, "warning: %s\n", damage.c_str());
  opened.up = parseUp(o.up);
  if (!o.global && !opened.up) opened.start = initialPose(o, opened.input->initialPose());
  opened.map = std::make_shared<LocalizationMap>(opened.model_file, params);
  chooseBackend(opened.map.get());
  for (const std::string& w : opened.map->mesh().report.warnings)
    std::fprintf(stderr, "warning: %s: %s\n", opened.model_file.c_str(), w.c_str());
  return opened;
}

}  // namespace edge_mcl
