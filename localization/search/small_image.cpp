#include "edge_mcl/localization/search/small_image.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "edge_mcl/core/image/edge_field.h"

namespace edge_mcl {

namespace {

// All lengths in pixels of the reduced image.

ImageParameters smallImageParameters(ImageParameters image) {
  image.blur_sigma = 0.8;
  image.edge_share = std::max(image.edge_share, 0.1);
  image.straight_segments = false;
  image.mask_dilation = 2;
  image.orientation_tolerance_deg = std::max(image.orientation_tolerance_deg, 25.0);
  image.search_length = 16;
  image.clutter_window = 32;
  if (image.contrast_window > 0) image.contrast_window = 32;
  return image;
}

LikelihoodParameters withSigma(const Parameters& params, double sigma) {
  LikelihoodParameters likelihood = searchLikelihood(params);
  likelihood.model =
      LikelihoodModel::kRobust;  // comparable with more and less of the model in view
  likelihood.sigma = sigma;
  likelihood.border_fade = 2;
  return likelihood;
}

RefinementParameters smallRefinement(RefinementParameters refinement) {
  refinement.search_length = 12;
  refinement.final_search_length = 4;
  refinement.sigma = 1;
  return refinement;
}

constexpr double kBroad = 4, kSharp = 1.5;  // sigma of the two likelihoods, pixels
// The scores are not centred: a model edge without image edge costs its full log-ratio. So an image
// of a bare wall speaks against poses with many model edges in view. With centred scores chance
// costs nothing. These poses would then keep the score of every line that fits by chance.
constexpr bool kCentred = false;

}  // namespace

LikelihoodParameters searchLikelihood(const Parameters& params) {
  // A weaker correlation makes the sum over the lines count more. The factor keeps the scores of
  // images with few lines in the range of the filter's scores.
  constexpr double kScale = 0.3;
  LikelihoodParameters likelihood = params.likelihood;
  likelihood.line_correlation = params.search.line_correlation;
  likelihood.scale *= kScale;
  return likelihood;
}

SmallImages::SmallImages(const Parameters& params, int width, double sample_step, uint32_t thinning)
    : image_(smallImageParameters(params.image)),
      broad_(withSigma(params, kBroad)),
      sharp_(withSigma(params, kSharp)),
      broad_levels_(image_, broad_, kCentred),
      sharp_levels_(image_, sharp_, kCentred),
      refiner_(smallRefinement(params.refinement), sharp_, image_),
      width_(width),
      // The visible sets are thinned already, so their samples are farther apart.
      sample_step_(sample_step * thinning) {}

std::shared_ptr<const SmallImage> SmallImages::make(const PreparedImage& image) const {
  auto small = std::make_shared<SmallImage>();
  const CameraModel& full = image.frame.camera;
  const int factor = std::max(1, full.width / width_);
  CameraModel& camera = small->camera = full;
  camera.width = full.width / factor;
  camera.height = full.height / factor;
  camera.fx = full.fx / factor;
  camera.fy = full.fy / factor;
  camera.cx = (full.cx + 0.5) / factor - 0.5;
  camera.cy = (full.cy + 0.5) / factor - 0.5;
  camera.validate("reduced image");
  const cv::Rect used(0, 0, camera.width * factor, camera.height * factor);
  cv::Mat grey, mask;
  cv::resize(image.edges.grey(used), grey, {camera.width, camera.height}, 0, 0, cv::INTER_AREA);
  if (!image.edges.ignore.empty()) {
    cv::resize(image.edges.ignore(used), mask, grey.size(), 0, 0, cv::INTER_AREA);
    mask = mask > 127;
  }
  small->edges = findEdges(grey, mask, image_, "reduced image");
  small->pixels = EdgePixels(small->edges);
  const EdgeField field(small->edges, small->pixels, image_);
  small->broad = {camera, std::make_shared<ScoreTable>(field, broad_levels_), broad_, sample_step_};
  small->sharp = {camera, std::make_shared<ScoreTable>(field, sharp_levels_), sharp_, sample_step_};
  return small;
}

}  // namespace edge_mcl
