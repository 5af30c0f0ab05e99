/// A model with all that is needed to score camera poses in it: the front door of core/.
#pragma once

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
#include "edge_mcl/core/places/search_places.h"
#include "edge_mcl/core/pose_refiner.h"

namespace edge_mcl {

/// Durations of the stages of one image, milliseconds.
struct StageTimes {
  double edges = 0, field = 0, table = 0;
};

/// A camera image, ready to be compared with poses. Immutable and shareable.
struct PreparedImage {
  EdgeImage edges;
  EdgePixels pixels;  ///< of the edges
  LikelihoodFrame frame;
  StageTimes times;
};

/// What a camera saw and where it sits on the robot. Image and depth are of the same optical frame;
/// either may be null.
struct CameraView {
  std::shared_ptr<const PreparedImage> image;
  Pose T_base_camera = Pose::Identity();
  uint32_t thinning = 1;  ///< see LikelihoodFrame
  std::shared_ptr<const DepthPoints> depth = nullptr;
  uint32_t depth_sensor = 0;  ///< the same for all images of a sensor: its bias is learnt
};

class LocalizationMap {
 public:
  /// Loads and prepares a model file. @throws InputError, ParameterError
  LocalizationMap(const std::string& model_file, const Parameters& params);
  /// From a mesh in memory.
  LocalizationMap(MeshModel mesh, const Parameters& params);

  const Parameters& params() const { return params_; }
  const MeshModel& mesh() const { return *mesh_; }
  const EdgeModel& edges() const { return *edges_; }
  const Visibility& visibility() const { return *visibility_; }
  std::shared_ptr<const Visibility> sharedVisibility() const { return visibility_; }
  const LikelihoodBackend& backend() const { return *backend_; }
  /// Replaces the CPU backend. @param backend over sharedVisibility().
  void setBackend(std::unique_ptr<LikelihoodBackend> backend) { backend_ = std::move(backend); }

  /// @param mask empty for none. @throws InputError on a size that is not the camera's.
  std::shared_ptr<const PreparedImage> prepare(const CameraModel& camera, const cv::Mat& image,
                                               const cv::Mat& mask,
                                               const std::string& origin) const;

  bool usesImages() const { return params_.likelihood.cues != Cues::kDepth; }
  bool usesDepth() const { return depth_ != nullptr; }
  /// Null unless likelihood.cues asks for depth.
  const DepthLikelihood* depth() const { return depth_.get(); }
  std::shared_ptr<const DepthLikelihood> sharedDepth() const { return depth_; }
  /// @throws InputError, see makeDepthPoints.
  std::shared_ptr<const DepthPoints> prepareDepth(const DepthImage& image) const;

  /// Where the camera can be (search.clearance, search.enclosure). Made with the first call. Safe
  /// to call from several threads.
  std::shared_ptr<const FreeSpace> freeSpace() const;
  /// Made with the first call, which takes seconds. Safe to call from several threads.
  /// @throws InputError, see SearchPlaces.
  std::shared_ptr<const SearchPlaces> searchPlaces() const;

  /// The thinning at which about `most` samples are inside the image at this pose of the base;
  /// 0 = all.
  uint32_t thinningFor(const CameraView& view, const Pose& base_pose, size_t most) const;

  /// Scores T_map_base poses: sums over the views.
  std::vector<PoseScore> evaluate(const std::vector<CameraView>& views,
                                  const std::vector<Pose>& base_poses) const;

  /// Refines T_map_base; visibility is taken at the start.
  RefinementResult refine(const std::vector<CameraView>& views, const Pose& start,
                          const std::optional<PoseGaussian>& prior) const;
  /// The same, cheaper and less exact: refinement.start_iterations and start_samples.
  RefinementResult refineRoughly(const std::vector<CameraView>& views, const Pose& start,
                                 const std::optional<PoseGaussian>& prior) const;
  /// Only counts what is visible and matched at a pose, as refine() does at its last step.
  RefinementResult match(const std::vector<CameraView>& views, const Pose& pose) const {
    return refine(views, pose, std::nullopt, {1, params_.refinement.max_samples});
  }

 private:
  void build(const std::string& model_file);
  RefinementResult refine(const std::vector<CameraView>& views, const Pose& start,
                          const std::optional<PoseGaussian>& prior,
                          const RefinementEffort& effort) const;
  Parameters params_;
  // Behind pointers: Visibility refers to mesh and edges, and the map can be moved.
  std::unique_ptr<MeshModel> mesh_;
  std::unique_ptr<EdgeModel> edges_;
  std::shared_ptr<Visibility> visibility_;
  std::unique_ptr<LikelihoodBackend> backend_;
  std::shared_ptr<const ScoreLevels> levels_;
  std::unique_ptr<PoseRefiner> refiner_;
  std::shared_ptr<const DepthLikelihood> depth_;
  struct LazySearch {
    std::mutex space_mutex, places_mutex;
    std::shared_ptr<const FreeSpace> space;
    std::shared_ptr<const SearchPlaces> places;
  };
  std::unique_ptr<LazySearch> search_ = std::make_unique<LazySearch>();
};

}  // namespace edge_mcl
