/// Runs the localizer over a recorded sequence, image by image.
#pragma once

#include "edge_mcl/core/localization_map.h"
#include "edge_mcl/core/recordings/sequence.h"
#include "edge_mcl/localization/tracking/live_localizer.h"

namespace edge_mcl {

class SequenceLocalizer {
 public:
  /// Both references must outlive this object. The base is the camera, T_map_base = T_map_camera.
  SequenceLocalizer(const LocalizationMap& map, const Sequence& sequence, bool use_masks);

  /// Overrides the spread of the first particles (else the sequence's own): m, rad.
  void setInitialSpread(double std_position, double std_angle);
  /// Forgets the sequence's initial pose: it is looked for in the whole model.
  /// @param up_camera which way is up in the first image, camera axes, if known.
  void searchEverywhere(const std::optional<Eigen::Vector3d>& up_camera);

  size_t frameCount() const { return sequence_.frames.size(); }
  /// Processes the next image. Unreadable input is reported in the result, not thrown.
  LiveResult step();
  /// Of the last step: reading its files.
  double readingMs() const { return reading_ms_; }
  const LiveLocalizer& localizer() const { return localizer_; }

 private:
  const LocalizationMap& map_;
  const Sequence& sequence_;
  bool use_masks_;
  LiveLocalizer localizer_;
  std::optional<Eigen::Vector3d> up_camera_;
  size_t next_ = 0;
  double reading_ms_ = 0;
};

}  // namespace edge_mcl
