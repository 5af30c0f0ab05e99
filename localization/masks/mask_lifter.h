/// Removes a mask along model edges that the images show under it. A mask should hide only objects
/// that are not in the map. But a network may also mask an object that is in the map (a screen, a
/// cupboard), because it looks like one of these. Then the images show the edges of this object
/// where the model has them, from every camera pose.
#pragma once

#include <map>
#include <optional>
#include <vector>

#include "edge_mcl/core/localization_map.h"
#include "edge_mcl/localization/masks/lines_under_mask.h"

namespace edge_mcl {

/// Removes (lifts) masks along model lines that are seen under them.
///
/// A line is seen in an image when at least 24 pixels of it lie under one connected part of the
/// mask and at least eight tenths of this length has an image edge. The mask is lifted along a line
/// that was seen in the last three images, at the poses found in them, and is seen in the present
/// image at the expected pose. The edges of an object in front of the line may lie upon it by
/// chance, but not for long while the camera or the object moves.
class MaskLifter {
 public:
  /// Lifts the mask of one image along the lines that are seen under it.
  /// @param view number of the camera on the robot. @param image of the size of the camera.
  /// @param mask CV_8U, non-zero = ignored. @param T_map_camera expected pose, with an error of at
  /// most a few pixels in the image.
  /// @return `mask` itself when nothing is lifted, otherwise a changed copy.
  /// @throws InputError when the image cannot be used.
  cv::Mat lift(size_t view, const LocalizationMap& map, const CameraModel& camera,
               const cv::Mat& image, const cv::Mat& mask, const Pose& T_map_camera);

  /// Counts, for every line, in how many images in a row it was seen under the mask. It uses the
  /// image of the last call of lift() for each camera, at the pose that was found with these
  /// images.
  /// @param base_pose T_map_base. @param T_base_camera extrinsics, by number of the camera.
  void learn(const LocalizationMap& map, const Pose& base_pose,
             const std::vector<Pose>& T_base_camera);
  /// Forgets all counts. To be called after an image that was not used or did not confirm the pose.
  void forget();

 private:
  /// The last image of a camera.
  struct Seen {
    CameraModel camera;
    cv::Mat mask;
    EdgePixels edges;  // found without the mask
  };
  struct View {
    std::optional<Seen> last;           // not yet used by learn()
    std::map<uint32_t, int> confirmed;  // line of the model -> images in a row that showed it
  };
  std::map<size_t, View> views_;  // key: number of the camera
};

}  // namespace edge_mcl
