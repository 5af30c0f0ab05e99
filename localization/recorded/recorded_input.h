/// A recording as input of the localizer, moment by moment.
#pragma once

#include <optional>
#include <string>

#include "edge_mcl/core/recordings/text_table.h"
#include "edge_mcl/localization/tracking/live_localizer.h"

namespace edge_mcl {

class RecordedInput {
 public:
  virtual ~RecordedInput() = default;
  virtual size_t imageCount() const = 0;
  /// T_map_base as recorded; none where the recording does not say.
  virtual const std::optional<PoseGaussian>& initialPose() const = 0;
  /// T_map_base; empty where it is not known.
  virtual const Trajectory& truth() const = 0;
  /// What of the recording as a whole is missing, in one line; empty: nothing.
  virtual std::string damage() const { return {}; }
  /// The next moment. One that cannot be read has no views and says why. @return false at the end.
  virtual bool next(LiveInput* input, std::string* problem) = 0;
};

}  // namespace edge_mcl
