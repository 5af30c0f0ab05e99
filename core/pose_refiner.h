/// Gauss-Newton refinement of a camera pose on the distances along the normals.
///
/// The residuals are those of the likelihood: for a visible sample, the signed distance along the
/// normal of its projected edge to the nearest image edge of matching direction (the scheme of
/// C. Harris, "Tracking with rigid models", 1992; T. Drummond, R. Cipolla, PAMI 24(7), 2002).
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "edge_mcl/core/base/normal_equations.h"
#include "edge_mcl/core/base/parameters.h"
#include "edge_mcl/core/base/se3.h"
#include "edge_mcl/core/camera/camera_model.h"
#include "edge_mcl/core/depth/depth_likelihood.h"
#include "edge_mcl/core/edges/visibility.h"
#include "edge_mcl/core/image/edge_pixels.h"
#include "edge_mcl/core/image/image_edges.h"

namespace edge_mcl {

/// One camera of the robot at the moment of an update: its image, its depth image, or both.
struct RefinementView {
  const CameraModel* camera = nullptr;  ///< null: no image
  const EdgeImage* image = nullptr;
  const EdgePixels* pixels = nullptr;  ///< of the image
  std::shared_ptr<const VisibleSet> visible;
  Pose T_base_camera = Pose::Identity();
  const DepthPoints* depth = nullptr;
};

struct RefinementResult {
  Pose pose = Pose::Identity();              ///< T_map_base
  Matrix6 covariance = Matrix6::Identity();  ///< in the tangent space at `pose` (base frame)
  int matched_samples = 0;  ///< samples with an image edge in reach at the last step
  int used_samples = 0;     ///< samples inside the image at the last step
  int matched_points = 0;   ///< depth points that are probably on the model, at the last step
  bool converged = false;   ///< the last step moved less than 0.1 mm and 0.01 degrees
};

/// How much a refinement may cost.
struct RefinementEffort {
  int iterations = 0;
  int samples = 0;  ///< per camera
};

class PoseRefiner {
 public:
  PoseRefiner(RefinementParameters refinement, LikelihoodParameters likelihood,
              ImageParameters image);
  /// Depth images are used with this.
  void setDepth(std::shared_ptr<const DepthLikelihood> depth) { depth_ = std::move(depth); }

  /// @param start T_map_base. @param prior Gaussian that the result is pulled to, if any.
  /// Without prior and with too few edges and points (six independent ones are needed) the start is
  /// returned with matched_samples + matched_points < 6.
  RefinementResult refine(const std::vector<RefinementView>& views, const Pose& start,
                          const std::optional<PoseGaussian>& prior,
                          const RefinementEffort& effort) const;

 private:
  struct ChosenSamples;
  ChosenSamples choose(const RefinementView& view, const Pose& base_pose, int most) const;
  NormalEquations linearize(const RefinementView& view, const ChosenSamples& chosen,
                            const Pose& base_pose, double search_length, double sigma,
                            const Matrix6* prior_covariance) const;
  NormalEquations linearizeDepth(const RefinementView& view, const Pose& base_pose,
                                 double progress) const;
  std::shared_ptr<const DepthLikelihood> depth_;
  RefinementParameters refinement_;
  LikelihoodParameters likelihood_;
  ImageParameters image_;
};

/// d pixel / d xi of a point fixed in the map, for T_map_camera * exp(xi).
/// @param point_camera the point in camera axes. @return false when it cannot be projected.
bool pixelJacobian(const CameraModel& camera, const Eigen::Vector3d& point_camera,
                   Eigen::Vector2d* pixel, Eigen::Matrix<double, 2, 6>* jacobian);

}  // namespace edge_mcl
