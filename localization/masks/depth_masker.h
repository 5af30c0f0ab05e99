/// Masks what a depth camera sees in front of the model. It needs no network and no light.
#pragma once

#include <map>
#include <opencv2/core.hpp>
#include <vector>

#include "edge_mcl/core/depth/foreign_points.h"
#include "edge_mcl/core/localization_map.h"

namespace edge_mcl {

/// The cues whose images the localizer needs: depth images as well when they only make masks.
Cues neededImages(const Parameters& params);

/// Makes masks from depth images and the expected pose (foreignPoints()).
///
/// A wrong pose must not mask the truth away: seen from a wrong pose, the building itself lies in
/// front of the model. So the masks are only made while the pose is likely (the caller's task), and
/// a mask that grows by a quarter of the image at once is held back. The image without it then
/// tells whether the pose is still right.
class DepthMasker {
 public:
  /// Foreign points of one depth sensor.
  struct Foreign {
    ForeignPoints points;
    Pose T_base_depth = Pose::Identity();
    double focal_length = 0;  ///< of the depth camera, pixels
  };

  /// Finds the foreign points of a depth image. They are none when the model has no faces.
  /// @param T_map_base expected pose with its covariance. @param T_base_depth extrinsics.
  /// @param lists_model whether what is of the model is listed, for other masks.
  /// @throws InputError when the depth image cannot be used.
  static Foreign find(const LocalizationMap& map, const DepthImage& image,
                      const PoseGaussian& T_map_base, const Pose& T_base_depth,
                      bool lists_model = true);

  /// Adds foreign points to the mask of an image, and takes what is of the model out of it: a
  /// network may take a cupboard of the model for something that moves.
  /// @param view number of the camera on the robot. @param mask CV_8U of the size of the camera, or
  /// empty. @param T_base_camera extrinsics. @param most largest share of the image that may be
  /// masked. @return the changed mask; `mask` itself when nothing changes, or when the foreign
  /// points are held back.
  cv::Mat add(size_t view, const std::vector<Foreign>& foreign, const CameraModel& camera,
              const Pose& T_base_camera, double most, const cv::Mat& mask);

  /// To be called when the pose is no longer likely.
  void forget() { shares_.clear(); }

 private:
  std::map<size_t, double> shares_;  // foreign share of the last image, by number of the camera
};

}  // namespace edge_mcl
