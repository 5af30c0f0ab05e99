/// Refines a pose in the full images and scores the result.
#pragma once

#include <cmath>
#include <memory>
#include <vector>

#include "edge_mcl/core/localization_map.h"
#include "edge_mcl/localization/search/image_contours.h"
#include "edge_mcl/localization/search/pose_tolerances.h"
#include "edge_mcl/localization/search/small_image.h"

namespace edge_mcl {

/// A refined pose and its scores in the images.
struct FoundPose {
  Pose pose = Pose::Identity();          ///< T_map_base
  Matrix6 covariance = Matrix6::Zero();  ///< of the refinement with its prior; tangent space
  double log_likelihood = 0;             ///< nats, see PoseSharpener::sharpen
  double evidence = 0;                   ///< mean per line, see UpdateReport::evidence_per_line
  /// Share of the visible samples with an image edge in reach; negative if there was no image.
  double match_ratio = -1;
  /// Share of the long image contours that lie on a model edge; negative if there were none.
  double contour_share = -1;
  /// Share of the depth points on the model; negative if there were none.
  double depth_agreement = -1;
};

/// The views of one moment, with the data that the search computes once and uses several times.
struct SearchViews {
  std::vector<CameraView> views;
  std::vector<std::shared_ptr<const ImageContours>> contours;  ///< of each view; null without image
  std::vector<std::shared_ptr<const SmallImage>> small;        ///< of each view; null without image
};

/// Whether two poses are closer than both limits. @param distance metres. @param angle radians.
bool isNear(const Pose& a, const Pose& b, double distance, double angle);
inline bool isNear(const Pose& a, const Pose& b, const PoseTolerance& limit) {
  return isNear(a, b, limit.position, limit.angle);
}

/// Largest rotation of a camera, rad, for which a set from visibleInView() stays complete. After a
/// larger one the visible samples are computed anew.
constexpr double kTurnInView = 25 * kDegree;

/// The samples of the model that a camera sees, including those that it sees after a rotation of up
/// to kTurnInView. @param thinning only every so many-th sample of the model is used.
std::shared_ptr<const VisibleSet> visibleInView(const Visibility& visibility,
                                                const Pose& T_map_camera, const CameraModel& camera,
                                                uint32_t thinning);

/// Refines and scores poses of the search in the full images. Safe to call from several threads.
class PoseSharpener {
 public:
  /// The map must outlive this object.
  explicit PoseSharpener(const LocalizationMap& map);

  /// Refines a pose in all images and depth images of a moment.
  ///
  /// The log-likelihood of the result is a sum of four parts. The first counts visible model edges
  /// that have an image edge. The second counts pixels of long image contours that lie on a model
  /// edge. The third counts pixels of visible model edges that have no image edge, with a negative
  /// sign. The fourth is the log-likelihood of the depth points.
  /// @param start T_map_base. @param prior Gaussian over T_map_base.
  FoundPose sharpen(const SearchViews& seen, const Pose& start, const PoseGaussian& prior) const;

 private:
  /// @param base T_map_base.
  std::shared_ptr<const VisibleSet> visibleFrom(const Pose& base, const CameraView& view) const;
  std::vector<RefinementView> viewsFrom(const SearchViews& seen, const Pose& base) const;

  const LocalizationMap& map_;
  uint32_t thinning_;
  PoseRefiner refiner_;
};

}  // namespace edge_mcl
