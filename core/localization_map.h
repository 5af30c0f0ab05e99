/// A 3D model with everything that is needed to score camera poses in it. LocalizationMap is the
/// entry point of core/.
#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "edge_mcl/core/base/parameters.h"
#include "edge_mcl/core/depth/depth_likelihood.h"
#include "edge_mcl/core/edges/edge_model.h"
#include "edge_mcl/core/edges/visibility.h"
#include "edge_mcl/core/image/edge_pixels.h"
#include "edge_mcl/core/image/image_edges.h"
#include "edge_mcl/core/likelihood/cpu_backend.h"
#include "edge_mcl/core/mesh/mesh_model.h"
#include "edge_mcl/core/places/prepared_places.h"
#include "edge_mcl/core/places/search_places.h"
#include "edge_mcl/core/pose_refiner.h"

namespace edge_mcl {

/// Durations of the stages in which one image is prepared, milliseconds. Field and table are 0 when
/// the backend makes its own tables.
struct StageTimes {
  double edges = 0, field = 0, table = 0;
};

/// A camera image that is ready to be compared with poses. It is immutable and can be shared.
struct PreparedImage {
  EdgeImage edges;
  EdgePixels pixels;  ///< edge pixels of `edges`
  LikelihoodFrame frame;
  StageTimes times;
  double pixel_scale = 1;  ///< see pixelScale()
};

/// Data of one camera at one moment, and the pose of the camera on the robot. Image and depth image
/// belong to the same optical frame. Either may be null.
struct CameraView {
  std::shared_ptr<const PreparedImage> image;
  Pose T_base_camera = Pose::Identity();  ///< camera pose in the base frame (extrinsics)
  uint32_t thinning = 1;                  ///< see LikelihoodFrame
  std::shared_ptr<const DepthPoints> depth = nullptr;
  /// Equal for all images of one sensor, because the filter learns the bias of every sensor.
  uint32_t depth_sensor = 0;
};

/// Holds a model, its feature edges, its visibility and a likelihood backend. It prepares images
/// and depth images, and it scores and refines poses.
class LocalizationMap {
 public:
  /// Loads a model file and prepares it.
  /// @throws InputError when the file cannot be used, or when the model has no feature edges (with
  ///   images) or no faces (with depth images).
  /// @throws ParameterError when a parameter is illegal.
  LocalizationMap(const std::string& model_file, const Parameters& params);
  /// Prepares a mesh in memory. Feature edges are not required here.
  /// @throws InputError when depth images are used and the mesh has no faces.
  /// @throws ParameterError when a parameter is illegal.
  LocalizationMap(MeshModel mesh, const Parameters& params);

  const Parameters& params() const { return params_; }
  const MeshModel& mesh() const { return *mesh_; }
  const EdgeModel& edges() const { return *edges_; }
  const Visibility& visibility() const { return *visibility_; }
  std::shared_ptr<const Visibility> sharedVisibility() const { return visibility_; }
  const LikelihoodBackend& backend() const { return *backend_; }
  /// Replaces the CPU backend. @param backend must use sharedVisibility().
  void setBackend(std::unique_ptr<LikelihoodBackend> backend) { backend_ = std::move(backend); }

  /// Finds the edges of an image and makes its score table. The table is left out when the backend
  /// makes its own (LikelihoodBackend::makesTables()).
  /// @param image see toGrey().
  /// @param mask CV_8U, non-zero: ignored; empty: no mask.
  /// @param origin named in errors.
  /// @throws InputError when the size or type of image or mask is wrong, or the image is too large
  ///   for a table.
  std::shared_ptr<const PreparedImage> prepare(const CameraModel& camera, const cv::Mat& image,
                                               const cv::Mat& mask,
                                               const std::string& origin) const;

  bool usesImages() const { return params_.likelihood.cues != Cues::kDepth; }
  bool usesDepth() const { return depth_ != nullptr; }
  /// Likelihood of depth images. Null unless `likelihood.cues` asks for depth.
  const DepthLikelihood* depth() const { return depth_.get(); }
  std::shared_ptr<const DepthLikelihood> sharedDepth() const { return depth_; }
  /// Makes points of a depth image. @throws InputError, see makeDepthPoints().
  std::shared_ptr<const DepthPoints> prepareDepth(const DepthImage& image) const;

  /// Space in which the camera can be (`search.clearance`, `search.enclosure`). The first call
  /// computes it. Safe to call from several threads.
  std::shared_ptr<const FreeSpace> freeSpace() const;
  /// Places from which a search starts. The first call computes them, which takes seconds. Safe to
  /// call from several threads.
  /// @throws InputError, see SearchPlaces.
  std::shared_ptr<const SearchPlaces> searchPlaces() const;

  /// What places see, for a search that compares an image with all of them. Null when
  /// `search.prepared` is false, or the model surrounds nothing or has no right angles. The first
  /// call reads them from disk or computes them, which takes up to a minute. Safe to call from
  /// several threads.
  /// @param progress of the computation, called from any thread.
  /// @throws InputError, see PreparedPlaces.
  std::shared_ptr<const PreparedPlaces> preparedPlaces(
      const PreparedPlaces::Progress& progress = {}) const;

  /// Thinning at which about `most` visible samples are inside the image. It is 1 without an image.
  /// @param base_pose T_map_base.
  /// @param most 0 = all samples.
  uint32_t thinningFor(const CameraView& view, const Pose& base_pose, size_t most) const;

  /// Scores T_map_base poses. Every score is the sum over all views.
  std::vector<PoseScore> evaluate(const std::vector<CameraView>& views,
                                  const std::vector<Pose>& base_poses) const;

  /// Refines T_map_base. The visible samples are those of the start pose.
  /// @param prior Gaussian that pulls the result to its mean, if any.
  RefinementResult refine(const std::vector<CameraView>& views, const Pose& start,
                          const std::optional<PoseGaussian>& prior) const;
  /// Refines T_map_base with less effort and less accuracy: with `refinement.start_iterations`
  /// steps and about `refinement.start_samples` samples per camera.
  RefinementResult refineRoughly(const std::vector<CameraView>& views, const Pose& start,
                                 const std::optional<PoseGaussian>& prior) const;
  /// Counts the samples that are used and matched at a pose, with the search length of the last
  /// step of refine(). The pose of the result has moved by one step.
  RefinementResult match(const std::vector<CameraView>& views, const Pose& pose) const {
    return refine(views, pose, std::nullopt, {1, params_.refinement.max_samples});
  }
  /// Matches the model with the images at a pose, see PoseRefiner::observe().
  PoseObservation observe(const std::vector<CameraView>& views, const Pose& pose) const {
    return refiner_->observe(refinementViews(views, pose), pose);
  }

 private:
  void build(const std::string& model_file);
  /// @param pose T_map_base, whose visible samples are taken.
  std::vector<RefinementView> refinementViews(const std::vector<CameraView>& views,
                                              const Pose& pose) const;
  RefinementResult refine(const std::vector<CameraView>& views, const Pose& start,
                          const std::optional<PoseGaussian>& prior,
                          const RefinementEffort& effort) const;
  Parameters params_;
  std::string model_file_;  // empty for a mesh in memory
  // Pointers keep mesh and edges in place when the map is moved, because Visibility refers to them.
  std::unique_ptr<MeshModel> mesh_;
  std::unique_ptr<EdgeModel> edges_;
  std::shared_ptr<Visibility> visibility_;
  std::unique_ptr<LikelihoodBackend> backend_;
  /// Score levels of images with this pixel scale. Safe to call from several threads.
  std::shared_ptr<const ScoreLevels> levelsFor(double pixel_scale) const;
  struct ScaledLevels {
    std::mutex mutex;
    std::map<double, std::shared_ptr<const ScoreLevels>> of_scale;
  };
  std::unique_ptr<ScaledLevels> levels_ = std::make_unique<ScaledLevels>();
  std::unique_ptr<PoseRefiner> refiner_;
  std::shared_ptr<const DepthLikelihood> depth_;
  struct LazySearch {
    std::mutex space_mutex, places_mutex, prepared_mutex;
    bool is_prepared = false;
    std::shared_ptr<const FreeSpace> space;
    std::shared_ptr<const SearchPlaces> places;
    std::shared_ptr<const PreparedPlaces> prepared;
  };
  std::unique_ptr<LazySearch> search_ = std::make_unique<LazySearch>();
};

}  // namespace edge_mcl
