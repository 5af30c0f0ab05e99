/// Finds poses that may explain an image, in the whole model or around a guess.
///
/// Poses are tried from broad to sharp: very many against a broad likelihood of a reduced image;
/// the best of them are refined there and weighed sharply; the best of those in the full image.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "edge_mcl/core/base/random_source.h"
#include "edge_mcl/localization/filter/tilt_correction.h"
#include "edge_mcl/localization/search/pose_sharpener.h"

namespace edge_mcl {

class PoseSearch {
 public:
  /// The map must outlive this object, and makes its free space for it; places are made with the
  /// first search of the whole model.
  explicit PoseSearch(const LocalizationMap& map);

  /// Best first, none near another, up to about 10 cm and 3 degrees off: to be sharpened.
  /// @param views may be of several moments, as cameras of one rig. @param up roll and pitch;
  /// without, the first camera is taken to be held upright, looking up or down by some tens of
  /// degrees.
  std::vector<Pose> everywhere(const std::vector<CameraView>& views,
                               const std::optional<UpReading>& up, RandomSource* random);
  /// Tries these orientations (of the base) only, at more positions: in buildings of right angles a
  /// wrong position often has a right orientation.
  std::vector<Pose> everywhere(const std::vector<CameraView>& views,
                               const std::optional<UpReading>& up,
                               const std::vector<Eigen::Matrix3d>& rotations, RandomSource* random);
  /// Draws from a Gaussian instead.
  std::vector<Pose> around(const std::vector<CameraView>& views, const PoseGaussian& guess,
                           const std::optional<UpReading>& up, RandomSource* random);
  /// Elsewhere with the same orientation: along the main directions of the building through this
  /// pose. Bays, rows of windows, floors look alike from one to the next.
  std::vector<Pose> alike(const SearchViews& seen, const Pose& pose) const;

  SearchViews prepare(std::vector<CameraView> views) const;
  /// Refines one pose in the full images, see PoseSharpener.
  FoundPose sharpen(const SearchViews& seen, const Pose& start, const PoseGaussian& prior) const {
    return sharpener_.sharpen(seen, start, prior);
  }
  /// The same from the prior's mean, by way of the reduced images: odometry may be off by more than
  /// a refinement in the full image finds its way back from.
  FoundPose follow(const SearchViews& seen, const PoseGaussian& prior) const;

  /// Whether the cameras are where cameras can be: not in a wall, whose plane many edges lie in.
  bool admits(const std::vector<CameraView>& views, const Pose& pose) const;

  /// The prior for refining a pose that was found: wide, but for roll and pitch where known.
  PoseGaussian looseAround(const Pose& start, const std::optional<UpReading>& up) const;

 private:
  /// A base pose, and what the first camera sees from about there.
  struct Start {
    Pose pose;
    std::shared_ptr<const VisibleSet> visible;
    double score = 0;
    bool admitted = true;
  };
  using SmallViews = std::vector<std::shared_ptr<const SmallImage>>;

  SmallViews reduce(const std::vector<CameraView>& views) const;
  void score(const std::vector<CameraView>& views, const SmallViews& small, bool sharp,
             const std::shared_ptr<const VisibleSet>& visible, const std::vector<Pose>& poses,
             double* scores) const;
  std::vector<Pose> everywhere(
      const std::vector<CameraView>& views, const std::optional<UpReading>& up, size_t per_place,
      RandomSource* random,
      const std::function<Eigen::Matrix3d(size_t, double, RandomSource*)>& rotationOf);
  std::vector<Pose> finish(const std::vector<CameraView>& views, const SmallViews& small,
                           std::vector<Start> starts, const std::optional<UpReading>& up) const;

  const LocalizationMap& map_;
  uint32_t small_thinning_;
  SmallImages small_images_;
  PoseSharpener sharpener_;
  std::shared_ptr<const FreeSpace> space_;
  std::vector<Eigen::Vector3d> directions_;     // of the building
  std::shared_ptr<const SearchPlaces> places_;  // null before the first search of everything
};

}  // namespace edge_mcl
