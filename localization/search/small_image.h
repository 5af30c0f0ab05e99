/// Reduced camera images. In them a pose with a large error still finds its edges.
#pragma once

#include <memory>

#include "edge_mcl/core/localization_map.h"

namespace edge_mcl {

/// The likelihood with which the search tells places apart: that of the filter with
/// search.line_correlation and a smaller scale. The filter's own parameters are made to tell
/// neighbouring poses apart.
LikelihoodParameters searchLikelihood(const Parameters& params);

/// A camera image at a fraction of its size, with two likelihoods. The broad one scores poses
/// everywhere in the model. The sharp one scores the poses after their refinement.
struct SmallImage {
  CameraModel camera;  ///< of the reduced image
  EdgeImage edges;
  EdgePixels pixels;  ///< of `edges`
  LikelihoodFrame broad, sharp;
};

/// Makes reduced images, and holds the refiner for them.
class SmallImages {
 public:
  /// @param width smallest width of a reduced image, pixels; the factor of the reduction is a whole
  /// number. @param sample_step of the edge model, metres. @param thinning of the visible sets that
  /// reduced images will be compared with.
  SmallImages(const Parameters& params, int width, double sample_step, uint32_t thinning);

  /// Reduces an image and its mask, and finds the edges in the result.
  std::shared_ptr<const SmallImage> make(const PreparedImage& image) const;
  /// Refines poses in reduced images.
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
