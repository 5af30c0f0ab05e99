/// Common interface of all backends of the measurement model. They score poses in batches.
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

/// All data of one image that the likelihood needs.
struct LikelihoodFrame {
  CameraModel camera;
  std::shared_ptr<const ScoreTable> table;  ///< may be null when there is a picture
  LikelihoodParameters params;
  double sample_step = 0;  ///< distance between samples of the edge model, metres
  /// A sample counts when its number in the whole model is a multiple of this value. Scores are
  /// comparable only at the same thinning.
  uint32_t thinning = 1;
  /// The table can be made from it; may be null when there is a table.
  std::shared_ptr<const Picture> picture = nullptr;

  /// The table. If there is only a picture, the CPU makes the table now.
  /// @throws Error when there is neither.
  std::shared_ptr<const ScoreTable> tableHere() const;
};

/// Scale of the weight of a sample. The weight is min(1, scale * (|a| + |b|)), with (a, b) the
/// derivative of the pixel by the position along the line. In the robust model the product is the
/// spacing of the used samples in the image, in units of the correlation length. In the paper's
/// model the derivative is multiplied by the depth, so that only edges seen almost end-on fade.
double spacingScale(const LikelihoodFrame& frame);

/// Score of one pose.
struct PoseScore {
  /// Log W of equation (3), or in the robust model the scaled sum of log-ratios. Always finite.
  double log_likelihood = 0;
  /// Samples inside the image and not ignored; faded samples count partly.
  float sample_weight = 0;
  /// Number of lines with at least one of these samples. A line of weight n counts as min(1, n) in
  /// the paper's model and as n / (n + line_saturation) in the robust model.
  float line_count = 0;
  double depth_log_likelihood = 0;  ///< part of log_likelihood that comes from depth images
  float depth_points = 0;           ///< number of depth points
  float depth_points_on_model = 0;  ///< expected number of depth points on the model
  /// Sum of the scores of all lines, over all images. The mean of a line is this sum divided by
  /// line_count. It cannot be computed from log_likelihood, where lines of different images do not
  /// dilute one another. Set by LocalizationMap::evaluate().
  double line_score_sum = 0;

  /// Mean score of a line; 0 without lines.
  double scorePerLine() const { return line_count > 0 ? line_score_sum / line_count : 0; }
};

/// Scores poses against one image. Equal calls give equal bits. On the CPU a single pose gives the
/// same bits as in a larger batch. A device may add up a large batch in another order.
class LikelihoodBackend {
 public:
  virtual ~LikelihoodBackend() = default;
  /// Scores poses. @param camera_poses T_map_camera. @throws Error when a pose is not finite.
  virtual std::vector<PoseScore> evaluate(const LikelihoodFrame& frame,
                                          const std::vector<Pose>& camera_poses) const = 0;
  /// Name of the backend.
  virtual std::string name() const = 0;
  /// Whether evaluate() makes its own tables from pictures, so that frames of these images need no
  /// table.
  virtual bool makesTables(const ImageParameters&) const { return false; }
  /// Starts to work on the picture of a frame, while the caller does something else.
  virtual void prefetch(const LikelihoodFrame&) const {}
};

/// Checks a frame.
/// @throws Error when there is neither table nor picture.
/// @throws InputError when it does not have the size of the camera's images.
void checkFrame(const LikelihoodFrame& frame);
/// Checks a frame and poses.
/// @throws Error or InputError as checkFrame(), and Error when a pose is not finite.
void checkLikelihoodInput(const LikelihoodFrame& frame, const std::vector<Pose>& camera_poses);
/// Checks a pose. @throws Error when it is not finite.
void checkPose(const Pose& pose);

/// Total log-likelihood of a pose, from the two sums that a kernel produces.
double combineLines(const LikelihoodParameters& params, double line_sum, double line_count);
/// Mean score of a line, computed back from the result of combineLines(); 0 without lines.
double scorePerLine(const LikelihoodParameters& params, double log_likelihood, double line_count);

}  // namespace edge_mcl
