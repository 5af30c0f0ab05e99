/// Localizes a recording moment by moment for the viewer.
#pragma once

#include <memory>
#include <optional>

#include "edge_mcl/localization/recorded/recorded_localizer.h"
#include "edge_mcl/viewer/moments/view_moment.h"

namespace edge_mcl {

/// Runs a localizer over a recording.
class RecordedView {
 public:
  /// @param max_particles largest number of particles in a moment
  RecordedView(std::shared_ptr<const LocalizationMap> map, std::unique_ptr<RecordedInput> input,
               const RecordedStart& start, size_t max_particles);

  /// Localizes the next moment. @return false at the end.
  bool next(ViewMoment* moment);
  /// Restarts the localizer at a pose (T_map_base) with the next moment.
  void setPose(const PoseGaussian& pose) { localizer_.setPose(pose); }

  size_t imageCount() const { return localizer_.recording().imageCount(); }
  const LocalizationMap& map() const { return localizer_.localizer().map(); }

 private:
  std::optional<Pose> truthAt(double time) const;

  RecordedLocalizer localizer_;
  size_t max_particles_;
  std::optional<double> first_time_;
};

}  // namespace edge_mcl
