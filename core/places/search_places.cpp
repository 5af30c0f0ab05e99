#include "edge_mcl/core/places/search_places.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "edge_mcl/core/base/error.h"

namespace edge_mcl {

uint32_t SearchPlaces::thinningTo(const EdgeModel& model, size_t samples) {
  return static_cast<uint32_t>(std::max<size_t>(1, model.sample_along.size() / samples));
}

SearchPlaces::SearchPlaces(const FreeSpace& space, const Visibility& visibility,
                           const SearchParameters& params)
    : thinning(thinningFor(visibility.model())) {
  spacing = std::max(params.place_spacing, std::cbrt(space.volume() / params.max_places));
  for (const Eigen::Vector3d& position : space.places(spacing))
    places.push_back({position, nullptr});
  if (places.empty())
    throw InputError(
        "search: no place in the model is at least search.clearance away from all surfaces");
  tbb::parallel_for(size_t{0}, places.size(), [&](size_t i) {
    places[i].visible =
        std::make_shared<const VisibleSet>(visibility.exact(places[i].position, thinning));
  });
}

}  // namespace edge_mcl
