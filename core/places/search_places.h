/// Places all over the free space of a model, with the samples that are visible from them.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "edge_mcl/core/base/parameters.h"
#include "edge_mcl/core/edges/visibility.h"
#include "edge_mcl/core/places/free_space.h"

namespace edge_mcl {

/// Holds the places from which a search for the pose starts. It takes seconds for a building. It is
/// made once per map, at the first search.
struct SearchPlaces {
  struct Place {
    Eigen::Vector3d position;                   ///< map frame
    std::shared_ptr<const VisibleSet> visible;  ///< samples visible from the position, thinned
  };
  std::vector<Place> places;
  double spacing = 0;     ///< distance between neighbouring places, m
  uint32_t thinning = 1;  ///< thinning of the visible sets

  /// Covers the free space with about `params.max_places` places at most, `params.place_spacing`
  /// apart at least.
  /// @throws InputError when the free space holds no place.
  SearchPlaces(const FreeSpace& space, const Visibility& visibility,
               const SearchParameters& params);

  /// Thinning at which about `samples` samples of the model remain.
  static uint32_t thinningTo(const EdgeModel& model, size_t samples);
  /// Thinning that is used for the places: about 2500 samples of the model remain.
  static uint32_t thinningFor(const EdgeModel& model) { return thinningTo(model, 2500); }
};

}  // namespace edge_mcl
