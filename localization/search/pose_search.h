/// Finds poses that may explain an image, in the whole model or around a guess.
///
/// The search goes from broad to sharp. Very many poses are scored by a broad likelihood of the
/// reduced image. The best of them are refined in the reduced image and scored by its sharp
/// likelihood. The best of these are refined in the full image.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "edge_mcl/core/base/random_source.h"
#include "edge_mcl/localization/filter/tilt_correction.h"
#include "edge_mcl/localization/search/pose_sharpener.h"

namespace edge_mcl {

/// A sphere in which the camera is looked for.
struct SearchRegion {
  Eigen::Vector3d centre;  ///< map frame, m
  double radius = 0;       ///< m

  /// Where the camera may be when the base is near a guess.
  static SearchRegion around(const PoseGaussian& guess);
};

/// One step of the global search: from images to a list of poses, without memory between images.
class PoseSearch {
 public:
  /// Makes the free space of the map. The search places of the map are made at the first search of
  /// the whole model, which takes seconds. @param map must outlive this object.
  explicit PoseSearch(const LocalizationMap& map);

  /// Searches the whole model. @param views images and depth images; several moments can be given
  /// as cameras of one rig. @param up roll and pitch; without them the first camera is assumed to
  /// be held upright and to look up or down by some tens of degrees.
  /// @param region none: the whole model.
  /// @return T_map_base poses, best first, no two of them close to each other. They have errors of
  /// up to about 10 cm and 3 degrees, so they still need sharpen(). @throws InputError when the
  /// free space holds no place.
  std::vector<Pose> everywhere(const std::vector<CameraView>& views,
                               const std::optional<UpReading>& up, RandomSource* random,
                               const std::optional<SearchRegion>& region = std::nullopt);
  /// Searches the whole model with these orientations (R_map_base) only, at more positions. In
  /// buildings with right angles a hypothesis at a wrong position often has the right orientation.
  /// Parameters and result are those of the search without `rotations`.
  std::vector<Pose> everywhere(const std::vector<CameraView>& views,
                               const std::optional<UpReading>& up,
                               const std::vector<Eigen::Matrix3d>& rotations, RandomSource* random);
  /// Searches the whole model by the straight lines of the newest image, which are compared with
  /// what prepared places see. It takes a tenth of the time of everywhere(). Parameters and result
  /// are those of everywhere(). @return none when the map has no prepared places, or when no
  /// orientation makes lines of the image parallel to the building.
  std::vector<Pose> lookedUp(const std::vector<CameraView>& views,
                             const std::optional<UpReading>& up,
                             const std::optional<SearchRegion>& region = std::nullopt);
  /// false: lookedUp() finds nothing, because the places are not prepared yet.
  void useLookup(bool use) { uses_lookup_ = use; }
  /// Searches around a guess (T_map_base): tries random poses from the Gaussian. Other parameters
  /// and the result are those of everywhere().
  std::vector<Pose> around(const std::vector<CameraView>& views, const PoseGaussian& guess,
                           const std::optional<UpReading>& up, RandomSource* random);
  /// Searches for look-alikes of a pose (T_map_base): poses with the same orientation, along the
  /// main directions of the building through this pose. Neighbouring bays, rows of windows and
  /// floors look alike. @return T_map_base poses, best first, at most twelve.
  std::vector<Pose> alike(const SearchViews& seen, const Pose& pose) const;

  /// Makes the reduced images and the contours of views, which the search uses several times.
  SearchViews prepare(std::vector<CameraView> views) const;
  /// Refines one pose in the full images, see PoseSharpener.
  FoundPose sharpen(const SearchViews& seen, const Pose& start, const PoseGaussian& prior) const {
    return sharpener_.sharpen(seen, start, prior);
  }
  /// Refines the mean of the prior first in the reduced images, then in the full images. Odometry
  /// can have a larger error than a refinement in the full images alone corrects.
  FoundPose follow(const SearchViews& seen, const PoseGaussian& prior) const;

  /// Whether all cameras of a pose (T_map_base) are in free space, see FreeSpace::admits. A camera
  /// in a wall would score well, because many edges lie in the plane of the wall.
  bool admits(const std::vector<CameraView>& views, const Pose& pose) const;

  /// The prior for the refinement of a pose that was found (T_map_base). It is wide, except for
  /// roll and pitch if `up` gives them.
  PoseGaussian looseAround(const Pose& start, const std::optional<UpReading>& up) const;

 private:
  /// A pose to start a refinement from.
  struct Start {
    Pose pose;                                  ///< T_map_base
    std::shared_ptr<const VisibleSet> visible;  ///< from about the position of the first camera
    double score = 0;                           ///< nats, in the reduced images
    bool admitted = true;                       ///< see admits()
  };
  using SmallViews = std::vector<std::shared_ptr<const SmallImage>>;

  /// Reduced image of every view; null for a view without image.
  SmallViews reduce(const std::vector<CameraView>& views) const;
  /// Scores poses (T_map_base) in the reduced images, plus depth. @param sharp which of the two
  /// likelihoods of a reduced image. @param scores nats, one per pose.
  void score(const std::vector<CameraView>& views, const SmallViews& small, bool sharp,
             const std::shared_ptr<const VisibleSet>& visible, const std::vector<Pose>& poses,
             double* scores) const;
  /// The common part of both searches of the whole model. @param per_place poses per place.
  /// @param rotationOf R_map_base of pose number i at a place, from i, a random phase in [0, 1) of
  /// the place, and the random source of the place.
  std::vector<Pose> everywhere(
      const std::vector<CameraView>& views, const std::optional<UpReading>& up, size_t per_place,
      RandomSource* random,
      const std::function<Eigen::Matrix3d(size_t, double, RandomSource*)>& rotationOf,
      const std::optional<SearchRegion>& region = std::nullopt);
  /// Refines the best starts in the reduced images, and leaves out poses outside free space and
  /// poses near a better one.
  std::vector<Pose> finish(const std::vector<CameraView>& views, const SmallViews& small,
                           std::vector<Start> starts, const std::optional<UpReading>& up) const;

  const LocalizationMap& map_;
  uint32_t small_thinning_;
  SmallImages small_images_;
  PoseSharpener sharpener_;
  std::shared_ptr<const FreeSpace> space_;
  std::vector<Eigen::Vector3d> directions_;     // main directions of the building, map frame
  std::shared_ptr<const SearchPlaces> places_;  // null before the first search of the whole model
  std::shared_ptr<const PreparedPlaces> prepared_;  // null as well when the map has none
  bool uses_lookup_ = true;
};

}  // namespace edge_mcl
