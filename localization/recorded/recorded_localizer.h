/// Runs the localizer over a recording, moment by moment.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "edge_mcl/localization/recorded/recorded_input.h"
#include "edge_mcl/localization/tracking/live_localizer.h"

namespace edge_mcl {

/// Where the localization of a recording starts.
struct RecordedStart {
  std::optional<PoseGaussian> pose;        ///< T_map_base; none: it is searched in the whole model
  std::optional<Eigen::Vector3d> up_base;  ///< direction upwards in the first image, base axes
};

/// The rule for recordings of every kind: an image is used however little of the model is in view,
/// since a recording shows what the user wants to localize. `tracking.min_visible_samples` is 0.
TrackingParameters trackingOfRecordings(TrackingParameters tracking);

class RecordedLocalizer {
 public:
  RecordedLocalizer(std::shared_ptr<const LocalizationMap> map,
                    std::unique_ptr<RecordedInput> input, const RecordedStart& start);

  /// Localizes the next moment. Input that cannot be read is reported in the result, not thrown.
  /// @return false at the end of the recording
  bool next();
  /// The moment that `next` has localized.
  const LiveInput& input() const { return input_; }
  const LiveResult& result() const { return result_; }
  /// Time that reading the files of this moment took, ms.
  double readingMs() const { return reading_ms_; }

  /// Starts again at this pose (T_map_base) with the next moment. @throws InputError
  void setPose(const PoseGaussian& pose) { localizer_.setPose(pose); }
  const RecordedInput& recording() const { return *recording_; }
  const LiveLocalizer& localizer() const { return localizer_; }

 private:
  std::unique_ptr<RecordedInput> recording_;
  LiveLocalizer localizer_;
  std::optional<Eigen::Vector3d> up_base_;  // until it is used
  LiveInput input_;
  LiveResult result_;
  double reading_ms_ = 0;
};

}  // namespace edge_mcl
