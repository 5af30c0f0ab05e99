/// Options of the subcommands that localize a recording: a sequence directory, a bag or a rawlog.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "apps/common_options.h"
#include "edge_mcl/core/localization_map.h"
#include "edge_mcl/localization/recorded/recorded_input.h"

namespace edge_mcl {

struct RecordingOptions {
  std::string recording, model, initial_std, masks, up;
  std::string topics, initial_pose;  // of a bag or rawlog
  std::string camera;                // of a rawlog
  bool no_mask = false, depth = false, global = false;
  ParameterOptions parameters;

  void addTo(CLI::App* command);
};

enum class RecordingKind { kDirectory, kBag, kRawlog };
/// By the name's ending.
RecordingKind kindOf(const std::string& recording);

/// The method's parameters, with what --depth makes of them. @throws ParameterError
Parameters parametersOf(const RecordingOptions& options);

/// "0.1,3": metres and degrees, as metres and radians. @throws ParameterError
std::pair<double, double> parseInitialStd(const std::string& text);

/// "0,-1,0": a direction; empty: none. @throws ParameterError
std::optional<Eigen::Vector3d> parseUp(const std::string& text);

/// A recording, the map it is in, and where to begin.
struct OpenedRecording {
  std::string name, model_file;
  std::shared_ptr<LocalizationMap> map;
  std::unique_ptr<RecordedInput> input;
  std::optional<PoseGaussian> start;  ///< T_map_base; none: to be looked for
  std::optional<Eigen::Vector3d> up;  ///< base axes, in the first image
};
/// @param everything images and depth are read, whatever the localizer needs. Prints warnings.
/// @throws InputError, ParameterError
OpenedRecording openRecording(const RecordingOptions& options, bool everything);

/// @throws ParameterError when there are some of bags and rawlogs.
void checkOptionsOfDirectory(const RecordingOptions& options);

/// To the standard error.
void sayThatNoPoseWasFound(const std::string& recording);

}  // namespace edge_mcl
