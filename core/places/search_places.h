/// Places all over the inside of a model, with what a camera sees there.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "edge_mcl/core/base/parameters.h"
#include "edge_mcl/core/edges/visibility.h"
#include "edge_mcl/core/places/free_space.h"

namespace edge_mcl {

/// Takes seconds for a building; made once per map, when a pose is first looked for.
struct SearchPlaces {
  struct Place {
    Eigen::Vector3d position;                   ///< map frame
    std::shared_ptr<const VisibleSet> visible;  ///< thinned
  };
  std::vector<Place> places;
  double spacing = 0;     ///< m
  uint32_t thinning = 1;  ///< of the visible sets

  /// @throws InputError when the free space holds no place.
  SearchPlaces(const FreeSpace& space, const Visibility& visibility,
               const SearchParameters& params);

  /// The thinning of the samples at which so many of the model's are left, about.
  static uint32_t thinningTo(const EdgeModel& model, size_t samples);
  /// As used for the places.
  static uint32_t thinningFor(const EdgeModel& model) { return thinningTo(model, 2500); }
};

}  // namespace edge_mcl
