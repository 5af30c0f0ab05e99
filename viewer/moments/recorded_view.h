/// A recording, localized moment by moment for the viewer.
#pragma once

#include <memory>
#include <optional>

#include "edge_mcl/localization/recorded/recorded_input.h"
#include "edge_mcl/viewer/moments/view_moment.h"

namespace edge_mcl {

class RecordedView {
 public:
  /// @param start T_map_base; none: it is looked for in the whole model. @param up_base which way
  /// is up in the first image, if known.
  RecordedView(std::shared_ptr<const LocalizationMap> map, std::unique_ptr<RecordedInput> input,
               std::optional<PoseGaussian> start, std::optional<Eigen::Vector3d> up_base,
               size_t max_particles);

  /// The next moment. @return false at the end.
  bool next(ViewMoment* moment);
  /// Begins anew here with the next moment.
  void setPose(const PoseGaussian& pose) { localizer_.setPose(pose); }

  size_t imageCount() const { return input_->imageCount(); }
  const LocalizationMap& map() const { return localizer_.map(); }

 private:
  std::optional<Pose> truthAt(double time) const;

  std::unique_ptr<RecordedInput> input_;
  LiveLocalizer localizer_;
  std::optional<Eigen::Vector3d> up_base_;
  size_t max_particles_;
  std::optional<double> first_time_;
};

}  // namespace edge_mcl
