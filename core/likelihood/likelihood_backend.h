/// One batch interface for the measurement model, whatever computes it.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "edge_mcl/core/base/parameters.h"
#include "edge_mcl/core/base/se3.h"
#include "edge_mcl/core/camera/camera_model.h"
#include "edge_mcl/core/edges/visibility.h"
#include "edge_mcl/core/likelihood/picture.h"
#include "edge_mcl/core/likelihood/score_table.h"

namespace edge_mcl {

/// Everything about one image that the likelihood needs.
struct LikelihoodFrame {
  CameraModel camera;
  std::shared_ptr<const ScoreTable> table;  ///< may be null where there is a picture
  LikelihoodParameters params;
  double sample_step = 0;  ///< of the edge model, metres
  /// Only every so many-th sample of the model counts, by its number in the whole model. Scores are
  /// comparable only at the same thinning.
  uint32_t thinning = 1;
  std::shared_ptr<const Picture> picture = nullptr;

  /// The table, made now where there is only the picture. @throws Error when there is neither.
  std::shared_ptr<const ScoreTable> tableHere() const;
};

/// Factor of a sample's weight: min(1, scale * (|a| + |b|)), with (a, b) the derivative of the
/// pixel by the position along the line. In the robust model the product is the spacing of the
/// used samples in the image in units of the correlation length. In the paper's model the
/// derivative is multiplied by the depth, so that only edges seen almost end-on fade.
double spacingScale(const LikelihoodFrame& frame);

/// What the image says of one pose.
struct PoseScore {
  /// log W of equation (3), or the scaled sum of log-ratios (robust). Always finite.
  double log_likelihood = 0;
  float sample_weight = 0;  ///< samples inside the image and not ignored (faded ones count partly)
  /// Lines with at least one such sample; in the robust model the sum of how far each is saturated.
  float line_count = 0;
  double depth_log_likelihood = 0;  ///< the part of log_likelihood that is of depth images
  float depth_points = 0;
  float depth_points_on_model = 0;
  /// What all lines score together, over all images: the mean of a line is this by line_count. Not
  /// to be had of log_likelihood, where lines of different images do not dilute one another. Set by
  /// LocalizationMap::evaluate.
  double line_score_sum = 0;

  double scorePerLine() const { return line_count > 0 ? line_score_sum / line_count : 0; }
};

/// Scores of poses against one image. The same call gives the same bits. On the CPU a single pose
/// gives the bits that it gives inside a larger batch; a device may add up a large batch in another
/// order.
class LikelihoodBackend {
 public:
  virtual ~LikelihoodBackend() = default;
  /// @param camera_poses T_map_camera. @throws Error when a pose is not valid (NaN).
  virtual std::vector<PoseScore> evaluate(const LikelihoodFrame& frame,
                                          const std::vector<Pose>& camera_poses) const = 0;
  virtual std::string name() const = 0;
  /// Whether frames of such images need no table, because evaluate() makes its own of the picture.
  virtual bool makesTables(const ImageParameters&) const { return false; }
  /// Starts with the frame's picture, while the caller does something else.
  virtual void prefetch(const LikelihoodFrame&) const {}
};

/// @throws Error when there is neither table nor picture, InputError when it is not of the camera's
///   size.
void checkFrame(const LikelihoodFrame& frame);
/// The same, and @throws Error when a pose is not finite.
void checkLikelihoodInput(const LikelihoodFrame& frame, const std::vector<Pose>& camera_poses);
/// @throws Error when it is not finite.
void checkPose(const Pose& pose);

/// Total log-likelihood from the two sums a kernel produces.
double combineLines(const LikelihoodParameters& params, double line_sum, double line_count);
/// The mean of the lines' scores, from what combineLines made of them; 0 without lines.
double scorePerLine(const LikelihoodParameters& params, double log_likelihood, double line_count);

}  // namespace edge_mcl
