#pragma once

#include "edge_mcl/core/base/parameters.h"

namespace edge_mcl {

/// Parameters of a search that is quick in a small building: fewer particles, places and hypotheses
/// than the defaults.
inline Parameters quickSearch() {
  Parameters params;
  params.filter.particles = 300;
  params.search.max_places = 1500;
  params.search.refined = 1500;
  params.search.hypotheses = 60;
  return params;
}

}  // namespace edge_mcl
