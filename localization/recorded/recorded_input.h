/// Interface of recordings that feed the localizer, one moment at a time.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "edge_mcl/core/recordings/text_table.h"
#include "edge_mcl/localization/tracking/live_localizer.h"

namespace edge_mcl {

/// Reads a recording (directory, bag or rawlog) moment by moment, in the order of the recording.
class RecordedInput {
 public:
  virtual ~RecordedInput() = default;
  /// Number of images of the whole recording.
  virtual size_t imageCount() const = 0;
  /// T_map_base at the first image; none if the recording holds no initial pose.
  virtual const std::optional<PoseGaussian>& initialPose() const = 0;
  /// Ground truth, T_map_base; empty if the recording holds none.
  virtual const Trajectory& truth() const = 0;
  /// One line that says which part of the recording is missing; empty if nothing is missing.
  virtual std::string damage() const { return {}; }
  /// What the user should know about how the recording is read, one line each.
  virtual std::vector<std::string> notes() const { return {}; }
  /// Reads the next moment. Data that cannot be read are left out of `input`.
  /// @param problem one line about the data that were left out; empty if there are none.
  /// @return false at the end of the recording.
  virtual bool next(LiveInput* input, std::string* problem) = 0;
};

}  // namespace edge_mcl
