/// Likely poses of a single image, with probabilities.
#pragma once

#include <optional>
#include <vector>

#include "edge_mcl/localization/search/pose_search.h"

namespace edge_mcl {

/// One of the poses that an image may have.
struct RankedPose {
  FoundPose found;         ///< T_map_base
  double probability = 0;  ///< that the image was taken within kSamePlace of it
};

/// Answer to "where was this image taken?".
struct RankedPoses {
  std::vector<RankedPose> poses;  ///< best first, no two within kSamePlace of each other
  double none = 1;                ///< probability that none of these is right
};

/// Turns the scores of different places into probabilities. The edges of an image depend on one
/// another, so a difference of scores tells less than the same difference of independent
/// log-likelihoods. It is divided by a temperature. "None of them" competes with a score of its
/// own. Both numbers were fitted to single images of simulated flights
/// (docs/decisions/search-single-image.md).
/// @param scores nats, of different places. @param keyframes number of moments that the scores are
///   the sums of. @return one probability for each, and the last one for
///   "none of them".
std::vector<double> placeProbabilities(const std::vector<double>& scores, size_t keyframes = 1);

/// Finds the poses that may explain one moment.
/// @param region none: the whole model. @param most number of poses in the answer. The
///   probabilities do not depend on it.
/// @throws InputError when the free space holds no place.
RankedPoses rankPoses(PoseSearch* search, const std::vector<CameraView>& views,
                      const std::optional<UpReading>& up, const std::optional<SearchRegion>& region,
                      size_t most, RandomSource* random);

}  // namespace edge_mcl
