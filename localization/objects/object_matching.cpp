// How groups of points find the objects that they belong to.
#include <algorithm>
#include <cmath>
#include <set>

#include "edge_mcl/localization/objects/object_follower.h"

namespace edge_mcl {

namespace {

/// An object is reported after so many images, over at least this time (s).
constexpr int kProvenSightings = 3;

/// Distance of the boxes up to which a group continues an object, m.
constexpr double kTouch = 0.25;
/// A second group continues the same object when it is so close, m.
constexpr double kPart = 0.1;
/// Large groups of one object that lie apart by more than this (m) in so many images in a row are
/// two objects: somebody has got up from a chair.
constexpr double kApart = 0.3;
constexpr int kTornImages = 5;
/// An object out of view may have moved by this much at once (m), and is not taller than before by
/// more than this (m), and its appearance differs by at most this (Hellinger distance; the light
/// changes it).
constexpr double kReach = 0.6, kSizeChange = 0.35, kOtherAppearance = 0.6;
/// Share of this difference when there is no image in colours or grey.
constexpr double kUnknownAppearance = 0.5;
/// A group is the object that stood at its place when so much of its places are the same.
constexpr double kSamePlaces = 0.3;
/// Number of a track that goes on in another one.
constexpr int kErased = -1;
double distanceOf(const Eigen::AlignedBox3d& a, const Eigen::AlignedBox3d& b) {
  return std::sqrt(a.squaredExteriorDistance(b));
}

}  // namespace

std::map<size_t, PointCluster> ObjectFollower::continued(double time,
                                                         std::vector<PointCluster>* clusters,
                                                         std::vector<PointCluster>* apart) {
  // Large groups first: they are the objects, and small ones their parts.
  std::stable_sort(clusters->begin(), clusters->end(),
                   [](const auto& a, const auto& b) { return pointsIn(a) > pointsIn(b); });
  std::map<size_t, PointCluster> parts;
  std::vector<PointCluster> left;
  std::set<size_t> torn;  // tracks with large groups that lie apart
  for (PointCluster& cluster : *clusters) {
    const Eigen::AlignedBox3d box = boxOf(cluster);
    std::vector<size_t> near;
    for (size_t i = 0; i < tracks_.size(); ++i) {
      const ObjectState& object = tracks_[i].object;
      if (!isFollowed(tracks_[i], time)) continue;
      const double passed = time - object.last_seen;
      const bool may_walk = object.is_moving || !tracks_[i].is_judged;
      const double reach = parts.count(i) ? kPart : kTouch + (may_walk ? kWalking * passed : 0);
      if (distanceOf(box, tracks_[i].newest) <= reach) near.push_back(i);
    }
    if (near.size() == 1 && parts.count(near[0]) && isLarge(cluster) &&
        distanceOf(box, boxOf(parts[near[0]])) > kApart) {
      torn.insert(near[0]);
      if (tracks_[near[0]].torn >= kTornImages) {
        apart->push_back(std::move(cluster));
        continue;
      }
    }
    if (near.empty()) {
      left.push_back(std::move(cluster));
      continue;
    }
    // Objects that touch make one group. Each point belongs to the nearest of them.
    std::map<size_t, PointCluster> shared;
    for (const VoxelPoint& v : cluster) {
      const Eigen::Vector3d p = v.point.cast<double>();
      const auto nearer = [&](size_t a, size_t b) {
        const Eigen::AlignedBox3d &box_a = tracks_[a].newest, &box_b = tracks_[b].newest;
        const double to_a = box_a.squaredExteriorDistance(p),
                     to_b = box_b.squaredExteriorDistance(p);
        return to_a != to_b ? to_a < to_b
                            : (p - box_a.center()).norm() < (p - box_b.center()).norm();
      };
      shared[*std::min_element(near.begin(), near.end(), nearer)].push_back(v);
    }
    for (const auto& [track, points] : shared)
      parts[track] = parts.count(track) ? joined(std::move(parts[track]), points) : points;
  }
  for (size_t i = 0; i < tracks_.size(); ++i)
    tracks_[i].torn = torn.count(i) > 0 ? tracks_[i].torn + 1 : 0;
  *clusters = std::move(left);
  return parts;
}

size_t ObjectFollower::standingAt(const PointCluster& cluster) const {
  size_t best = tracks_.size();
  double most = kSamePlaces * static_cast<double>(cluster.size());
  const Eigen::AlignedBox3d box = boxOf(cluster);
  for (size_t i = 0; i < tracks_.size(); ++i) {
    const Track& track = tracks_[i];
    if (track.is_gone || track.object.is_moving || distanceOf(box, track.object.box) > kTouch)
      continue;
    const auto same = std::count_if(cluster.begin(), cluster.end(), [&](const VoxelPoint& v) {
      return track.places.count(v.key) > 0;
    });
    if (static_cast<double>(same) <= most) continue;
    most = static_cast<double>(same);
    best = i;
  }
  return best;
}

size_t ObjectFollower::knownAgain(double time, const Track& found) const {
  size_t best = tracks_.size();
  double least = 1;
  for (size_t i = 0; i < tracks_.size(); ++i) {
    const Track& track = tracks_[i];
    if (track.object.number <= 0 || track.object.last_seen >= found.object.first_seen) continue;
    // What has always stood still does so out of view, unless its place was seen to be empty.
    const double walked = kWalking * std::min(kRemember, time - track.object.last_seen);
    const double reach = kReach + (track.is_gone || track.has_moved ? walked : 0);
    const double way = distanceOf(found.newest, track.object.box) / reach;
    const bool is_known = !found.appearance.empty() && !track.appearance.empty();
    const double unlike = is_known
                              ? differenceOf(found.appearance, track.appearance) / kOtherAppearance
                              : kUnknownAppearance;
    // A part may be hidden, so the new one may be smaller.
    const double taller = ((*found.size)[2] - (*track.size)[2]) / kSizeChange;
    if (way > 1 || unlike > 1 || taller > 1) continue;
    const double cost = (way + unlike + std::abs(taller) / 3) / 3;
    if (cost < least) {
      least = cost;
      best = i;
    }
  }
  return best;
}

void ObjectFollower::giveNumbers(double time) {
  for (Track& track : tracks_) {
    if (track.object.number != 0 || track.sightings < kProvenSightings) continue;
    const size_t known = knownAgain(time, track);
    if (known == tracks_.size()) {
      track.object.number = next_number_++;
      continue;
    }
    Track& before = tracks_[known];
    // The same thing, seen from another side.
    const bool stood = !before.has_moved && !before.is_gone && !before.object.is_moving &&
                       !track.has_moved && !track.object.is_moving &&
                       distanceOf(track.object.box, before.object.box) <=
                           kTouch + (*track.size)[1];  // its depth, which may be hidden
    if (stood) {
      track.object.still_since = before.object.still_since;
      track.object.box.extend(before.object.box);
      track.places.insert(before.places.begin(), before.places.end());
    }
    track.object.number = before.object.number;
    track.object.first_seen = before.object.first_seen;
    track.size = track.size->cwiseMax(*before.size);
    track.appearance = before.appearance;
    track.has_moved |= before.has_moved || before.is_gone;
    before.object.number = kErased;
  }
  tracks_.erase(std::remove_if(tracks_.begin(), tracks_.end(),
                               [](const Track& t) { return t.object.number == kErased; }),
                tracks_.end());
}

}  // namespace edge_mcl
