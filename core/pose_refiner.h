/// Gauss-Newton refinement of a pose with image edges and depth points.
///
/// The residual of a visible sample is its signed distance to the nearest image edge of matching
/// direction. As in the likelihood, the distance is measured along the normal of the projected
/// model edge (the scheme of C. Harris, "Tracking with rigid models", 1992; T. Drummond,
/// R. Cipolla, PAMI 24(7), 2002). The residual of a depth point is its distance from the model, see
/// DepthLikelihood::linearize().
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
#include "edge_mcl/core/pose_observation.h"

namespace edge_mcl {

/// Data of one camera at the moment of an update: its image, its depth image, or both.
struct RefinementView {
  const CameraModel* camera = nullptr;  ///< null: no image
  const EdgeImage* image = nullptr;
  const EdgePixels* pixels = nullptr;  ///< edge pixels of `image`
  double pixel_scale = 1;              ///< factor on all lengths in pixels, see pixelScale()
  /// Samples visible from the camera; needed with an image.
  std::shared_ptr<const VisibleSet> visible;
  Pose T_base_camera = Pose::Identity();  ///< camera pose in the base frame
  const DepthPoints* depth = nullptr;
};

/// Pose and covariance after a refinement, with the number of matches.
struct RefinementResult {
  Pose pose = Pose::Identity();              ///< T_map_base
  Matrix6 covariance = Matrix6::Identity();  ///< in the tangent space at `pose` (base frame)
  int matched_samples = 0;                   ///< samples that found an image edge at the last step
  int used_samples = 0;  ///< samples inside the image and outside the mask at the last step
  /// Depth points on the model with a probability above 0.5, at the last step.
  int matched_points = 0;
  bool converged = false;  ///< the last step moved less than 0.1 mm and 0.01 degrees
};

/// Effort of a refinement.
struct RefinementEffort {
  int iterations = 0;  ///< Gauss-Newton steps
  int samples = 0;     ///< about this many per camera
};

/// Refines poses in steps. From step to step the search length falls from
/// `refinement.search_length` to `refinement.final_search_length`.
class PoseRefiner {
 public:
  PoseRefiner(RefinementParameters refinement, LikelihoodParameters likelihood,
              ImageParameters image);
  /// Sets the likelihood of depth images. Without it refine() ignores depth images.
  void setDepth(std::shared_ptr<const DepthLikelihood> depth) { depth_ = std::move(depth); }

  /// Refines a pose. Without a prior a step needs six matches (samples and depth points together).
  /// With fewer matches the refinement ends early. It returns the pose reached so far (the start
  /// pose if this is the first step), with matched_samples + matched_points < 6.
  /// @param start T_map_base.
  /// @param prior Gaussian that pulls the result to its mean, if any.
  RefinementResult refine(const std::vector<RefinementView>& views, const Pose& start,
                          const std::optional<PoseGaussian>& prior,
                          const RefinementEffort& effort) const;

  /// Matches the model with the images at a pose, without moving it, as in the last step of a
  /// refinement without prior.
  PoseObservation observe(const std::vector<RefinementView>& views, const Pose& base_pose) const;

 private:
  struct Step;
  struct Match;
  enum class Outcome { kOutside, kUnmatched, kMatched };
  /// Samples of one camera that a refinement uses. They are chosen once, at the start pose.
  struct ChosenSamples {
    struct Sample {
      Eigen::Vector3d point, tangent;  // map frame
      double facing;
      bool ends_group;
      uint32_t group;
    };
    std::vector<Sample> samples;
    double stride = 1;           ///< every stride-th visible sample is chosen
    std::vector<size_t> pieces;  ///< borders of the pieces of work, always at ends of lines
  };
  ChosenSamples choose(const RefinementView& view, const Pose& base_pose, int most) const;
  Outcome match(const RefinementView& view, const ChosenSamples::Sample& sample, const Step& step,
                Match* match) const;
  static void add(const Match& match, double share, const Eigen::Vector2d& centre,
                  CameraObservation* camera, PoseObservation::Piece* piece);
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

/// Projects a point that is fixed in the map, and computes d pixel / d xi for
/// T_map_camera * exp(xi).
/// @param point_camera the point in camera axes, metres.
/// @return false when the point cannot be projected.
bool pixelJacobian(const CameraModel& camera, const Eigen::Vector3d& point_camera,
                   Eigen::Vector2d* pixel, Eigen::Matrix<double, 2, 6>* jacobian);

}  // namespace edge_mcl
