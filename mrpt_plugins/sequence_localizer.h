/// Runs the filter over a recorded sequence, image by image.
#pragma once

#include <memory>
#include <string>

#include "edge_mcl/core/localization_map.h"
#include "edge_mcl/core/sequence.h"
#include "edge_mcl/mrpt_plugins/pose_filter.h"

namespace edge_mcl {

/// Result of one image.
struct FrameResult {
  PoseGaussian estimate;  ///< T_map_camera
  UpdateReport report;
  StageTimes image_times;
  double reading_ms = 0;
  bool updated = false;  ///< false: pose predicted, as there was nothing to use
  std::string problem;   ///< one line: what could not be used, and why
  std::shared_ptr<const PreparedImage> image;  ///< null where not used
};

class SequenceLocalizer {
 public:
  /// Both references must outlive this object. The base is the camera.
  SequenceLocalizer(const LocalizationMap& map, const Sequence& sequence, bool use_masks);

  /// Overrides the spread of the first particles (else the sequence's own): m, rad.
  void setInitialSpread(double std_position, double std_angle);

  size_t frameCount() const { return sequence_.frames.size(); }
  /// Processes the next image. Unreadable input is reported in the result, not thrown.
  FrameResult step();
  const PoseFilter& filter() const { return filter_; }

 private:
  void predict(const SequenceFrame& frame);
  const LocalizationMap& map_;
  const Sequence& sequence_;
  bool use_masks_;
  PoseFilter filter_;
  size_t next_ = 0;
};

}  // namespace edge_mcl
