/// Options of the subcommands that localize a recording: a sequence directory, a bag or a rawlog.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "apps/common_options.h"
#include "edge_mcl/core/localization_map.h"
#include "edge_mcl/localization/recorded/recorded_localizer.h"

namespace edge_mcl {

/// The options. An empty text means that the option is not given.
struct RecordingOptions {
  std::string recording, model, initial_std, masks, up;
  std::vector<std::string> parts;  ///< all files of a recording in parts; the first is `recording`
  std::string topics;              ///< only for a bag
  std::string initial_pose, camera;
  bool no_mask = false, depth = false, global = false;
  ParameterOptions parameters;

  bool masksAreOfDepth() const { return masks == "depth"; }
  /// Whether the masks of the recording itself are used.
  bool usesOwnMasks() const { return !no_mask && !masksAreOfDepth(); }

  /// Adds the options to a subcommand.
  void addTo(CLI::App* command);
};

enum class RecordingKind { kDirectory, kBag, kRawlog, kVideo };
/// The kind of a recording: a directory, a bag by its first bytes, a rawlog or a video by the
/// ending of its name. What does not exist has the kind of its name.
/// @throws InputError when it was recorded by ROS 2
RecordingKind kindOf(const std::string& recording);

/// Reads a direction "x,y,z", e.g. "0,-1,0".
/// @return a unit vector; none for an empty text.
/// @throws ParameterError
std::optional<Eigen::Vector3d> parseUp(const std::string& text);

/// Parameters of the method. With `--depth`, likelihood.cues changes from edges to both. With
/// `--masks depth`, tracking.mask_by_depth is set.
/// @throws ParameterError, InputError
Parameters parametersOf(const RecordingOptions& options);

/// A recording that is open, its map, and where the localization starts.
struct OpenedRecording {
  std::string name, model_file;
  std::shared_ptr<LocalizationMap> map;
  std::unique_ptr<RecordedInput> input;
  RecordedStart start;
  /// Is added to the positions of the trajectory: the origin of the map frame in the coordinates of
  /// the model file, metres. Zero with `map.absolute_poses` false.
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  /// Pose that the trajectory holds: T_map_base. A directory has no base, so its trajectory holds
  /// T_map_camera.
  std::string trajectory_pose = "T_map_base";
};
/// Opens a recording without its model. Images and depth are read. Prints warnings on stderr.
/// @throws InputError, ParameterError, see openRecording()
std::unique_ptr<RecordedInput> openInput(const RecordingOptions& options);

/// Opens a recording and loads its model. Prints warnings on stderr.
/// @param everything true: images and depth are read even if the localizer does not need them.
/// @throws InputError when a file cannot be used or data are missing; ParameterError when an option
/// is wrong or does not fit the kind of recording
OpenedRecording openRecording(const RecordingOptions& options, bool everything);

}  // namespace edge_mcl
