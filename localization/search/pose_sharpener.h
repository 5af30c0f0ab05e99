/// Refines a pose in the full images, and says what they say of it.
#pragma once

#include <cmath>
#include <memory>
#include <vector>

#include "edge_mcl/core/localization_map.h"
#include "edge_mcl/localization/search/image_contours.h"
#include "edge_mcl/localization/search/small_image.h"

namespace edge_mcl {

/// A pose, refined, and what the images say of it.
struct FoundPose {
  Pose pose = Pose::Identity();          ///< T_map_base
  Matrix6 covariance = Matrix6::Zero();  ///< of the refinement, with its prior; tangent space
  double log_likelihood = 0;
  double evidence = 0;          ///< per line, see UpdateReport::evidence_per_line
  double match_ratio = -1;      ///< share of the visible samples with an image edge in reach;
                                ///< negative: there was no image
  double depth_agreement = -1;  ///< share of the depth points on the model; negative: none used
};

/// What was seen at one moment, with what the search asks of it more than once.
struct SearchViews {
  std::vector<CameraView> views;
  std::vector<std::shared_ptr<const ImageContours>> contours;  ///< of each; null without image
  std::vector<std::shared_ptr<const SmallImage>> small;        ///< likewise
};

/// Closer than this in position and angle.
bool isNear(const Pose& a, const Pose& b, double distance, double angle);

/// How far a refinement may turn a camera before what comes into view is looked up anew; rad.
constexpr double kTurnInView = 25 * M_PI / 180;

/// What a camera sees of the model, also after it was turned by kTurnInView.
std::shared_ptr<const VisibleSet> visibleInView(const Visibility& visibility,
                                                const Pose& T_map_camera, const CameraModel& camera,
                                                uint32_t thinning);

class PoseSharpener {
 public:
  /// The map must outlive this object.
  explicit PoseSharpener(const LocalizationMap& map);

  /// The log-likelihood of what it returns holds what the model's edges find in the images, what of
  /// the images' contours the model explains, and what it shows in vain.
  FoundPose sharpen(const SearchViews& seen, const Pose& start, const PoseGaussian& prior) const;

 private:
  std::shared_ptr<const VisibleSet> visibleFrom(const Pose& base, const CameraView& view) const;
  std::vector<RefinementView> viewsFrom(const SearchViews& seen, const Pose& base) const;

  const LocalizationMap& map_;
  uint32_t thinning_;
  PoseRefiner refiner_;
};

}  // namespace edge_mcl
