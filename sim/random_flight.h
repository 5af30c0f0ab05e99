/// A flight that nobody has to draw: random, by seed, and clear of the building.
#pragma once

#include "edge_mcl/sim/flight_path.h"
#include "edge_mcl/sim/scene.h"

namespace edge_mcl {

struct RandomFlight {
  double duration = 0;  ///< s; at least
  double speed = 0.8;   ///< m/s, on average
  uint64_t seed = 1;
  double clearance = 0.15;  ///< m to the building, all along
};

/// Waypoints inside the building, one after the other: each is in sight of the last, and the smooth
/// path through all keeps its clearance. It looks about where it flies.
/// @throws InputError when no such path is found, e.g. in a model that is not closed.
FlightPath randomFlight(const Scene& scene, const RandomFlight& request, const std::string& origin);

}  // namespace edge_mcl
