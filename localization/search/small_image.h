/// Reduced camera images, in which poses that are far off still find their edges.
#pragma once

#include <memory>

#include "edge_mcl/core/localization_map.h"

namespace edge_mcl {

/// The robust likelihood for telling places apart, where the filter's tells neighbouring poses
/// apart.
LikelihoodParameters searchLikelihood(const Parameters& params);

/// A camera image at a fraction of its size, with a broad likelihood to weigh poses everywhere and
/// a sharp one to weigh what refinement made of them.
struct SmallImage {
  CameraModel camera;
  EdgeImage edges;
  EdgePixels pixels;
  LikelihoodFrame broad, sharp;
};

/// Makes them, and refines poses in them.
class SmallImages {
 public:
  /// @param width px, at least; the reduction is a whole number.
  /// @param sample_step of the model. @param thinning of the sets of visible samples that poses
  /// will be compared with.
  SmallImages(const Parameters& params, int width, double sample_step, uint32_t thinning);

  std::shared_ptr<const SmallImage> make(const PreparedImage& image) const;
  const PoseRefiner& refiner() const { return refiner_; }

 private:
  ImageParameters image_;
  LikelihoodParameters broad_, sharp_;
  ScoreLevels broad_levels_, sharp_levels_;
  PoseRefiner refiner_;
  int width_;
  double sample_step_;
};

}  // namespace edge_mcl
