#include "edge_mcl/sim/random_flight.h"

#include <algorithm>
#include <cmath>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/base/random_source.h"

namespace edge_mcl {

namespace {

// m; additional clearance of waypoints, because the path swings out between them.
constexpr double kSpare = 0.2;

/// Whether rays in all six axis directions meet the building.
bool isInside(const Scene& scene, const Eigen::Vector3d& point) {
  Eigen::Vector3f directions[6];
  SceneHit hits[6];
  for (int i = 0; i < 6; ++i) {
    directions[i].setZero();
    directions[i][i / 2] = i % 2 ? 1 : -1;
  }
  scene.cast(point.cast<float>(), directions, 6, hits);
  return std::all_of(hits, hits + 6, [](const SceneHit& h) { return h.any(); });
}

/// Whether the path keeps its clearance from the time `from` on.
bool keepsClear(const Scene& scene, const FlightPath& path, double from, double clearance) {
  constexpr double kStep = 0.05;  // seconds
  Eigen::Vector3d last = path.at(from).translation();
  for (double t = from; t <= path.end(); t += kStep) {
    const Eigen::Vector3d here = path.at(t).translation();
    if (scene.clearance(here, clearance) < clearance) return false;
    if (t > from && scene.blocked(last.cast<float>(), here.cast<float>())) return false;
    last = here;
  }
  return true;
}

}  // namespace

FlightPath randomFlight(const Scene& scene, const RandomFlight& request,
                        const std::string& origin) {
  RandomSource random(request.seed);
  const Eigen::Vector3d low = scene.building().lowest.cast<double>();
  const Eigen::Vector3d size = scene.building().highest.cast<double>() - low;
  const double keep = request.clearance + kSpare;
  const auto anywhere = [&]() -> Eigen::Vector3d {
    return low +
           size.cwiseProduct(Eigen::Vector3d(random.uniform(), random.uniform(), random.uniform()));
  };
  const auto isFree = [&](const Eigen::Vector3d& p) {
    return scene.clearance(p, keep) >= keep && isInside(scene, p);
  };
  std::vector<Waypoint> points;
  double heading = 2 * M_PI * random.uniform();
  constexpr int kMostTries = 20000;  // for one waypoint
  int tries = 0;
  while (points.empty() || points.back().time < request.duration) {
    if (++tries > kMostTries)
      throw InputError(origin +
                       ": no random flight of this duration and clearance was found; is the "
                       "model closed?");
    const Eigen::Vector3d candidate = anywhere();
    if (points.empty()) {
      if (!isFree(candidate)) continue;
      points.push_back({0, candidate, heading});
      tries = 0;
      continue;
    }
    const Waypoint& last = points.back();
    const Eigen::Vector3d way = candidate - last.position;
    // The next waypoint is far enough to move, near enough to stay in the free part of the room,
    // and at most 30 degrees up or down.
    if (way.norm() < 0.4 || way.norm() > 3 || std::abs(way.z()) > 0.5 * way.norm()) continue;
    if (!isFree(candidate) || scene.blocked(last.position.cast<float>(), candidate.cast<float>()))
      continue;
    const double towards = std::atan2(way.y(), way.x()) + 0.6 * random.normal();
    const double turn = std::clamp(std::remainder(towards - heading, 2 * M_PI), -1.2, 1.2);
    // Turning takes time, too: the mean yaw rate is at most 0.6 rad/s.
    const double time = std::max(way.norm() / request.speed, std::abs(turn) / 0.6);
    points.push_back({last.time + time, candidate, heading + turn});
    // A new waypoint hardly changes the path before the fourth last one, so only the path after
    // that one is checked.
    const double from = points[points.size() > 3 ? points.size() - 4 : 0].time;
    if (keepsClear(scene, FlightPath::throughWaypoints(points, true, origin), from,
                   request.clearance)) {
      heading += turn;
      tries = 0;
    } else {
      points.pop_back();
    }
  }
  return FlightPath::throughWaypoints(points, true, origin);
}

}  // namespace edge_mcl
