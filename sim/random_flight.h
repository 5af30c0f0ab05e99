/// Makes a random flight path that keeps clear of the building.
#pragma once

#include "edge_mcl/sim/flight_path.h"
#include "edge_mcl/sim/scene.h"

namespace edge_mcl {

/// What the random flight must be like.
struct RandomFlight {
  double duration = 0;  ///< s; the flight is at least this long
  double speed = 0.8;   ///< m/s, mean between two waypoints; turns may make the flight slower
  uint64_t seed = 1;
  double clearance = 0.15;  ///< m; distance to the building that the whole path keeps
};

/// Draws waypoints inside the building and lays a smooth path through them. Every waypoint is in
/// sight of the one before. The yaw roughly follows the direction of flight. The same seed gives
/// the same path. @param origin named in errors.
/// @throws InputError when no path is found, e.g. in a model that is not closed.
FlightPath randomFlight(const Scene& scene, const RandomFlight& request, const std::string& origin);

}  // namespace edge_mcl
