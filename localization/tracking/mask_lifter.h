/// A mask hides what is not in the map. What a network takes for such, because it looks like it (a
/// screen, a cupboard), may be in the map all the same; then the images show its edges where the
/// model has them, from wherever the camera looks.
#pragma once

#include <map>
#include <optional>
#include <vector>

#include "edge_mcl/core/localization_map.h"
#include "edge_mcl/localization/tracking/lines_under_mask.h"

namespace edge_mcl {

/// Lifts masks along model edges that are seen under them. A line counts as seen when at least 24
/// pixels of it lie under one connected part of the mask and eight tenths of them have an image
/// edge; it is lifted when that was so in the last three images, at the poses found in them, and is
/// so in the present one, about where it is expected. Edges of what stands before it lie upon it by
/// chance, but not for long while the camera or they move.
class MaskLifter {
 public:
  /// Uses the model as it is seen from where the camera is expected.
  /// @param view which of the robot's cameras. @param T_map_camera to a few pixels.
  /// @return `mask` itself where nothing is lifted; a copy otherwise.
  cv::Mat lift(size_t view, const LocalizationMap& map, const CameraModel& camera,
               const cv::Mat& image, const cv::Mat& mask, const Pose& T_map_camera);

  /// What the images of the last calls of lift() show at the pose that was found by them.
  /// @param base_pose T_map_base. @param T_base_camera by view.
  void learn(const LocalizationMap& map, const Pose& base_pose,
             const std::vector<Pose>& T_base_camera);
  /// After an image at whose pose nothing can be learnt.
  void forget();

 private:
  struct Seen {
    CameraModel camera;
    cv::Mat mask;
    EdgePixels edges;
  };
  struct View {
    std::optional<Seen> last;           // not yet learnt from
    std::map<uint32_t, int> confirmed;  // line of the model: images in a row
  };
  std::map<size_t, View> views_;
};

}  // namespace edge_mcl
