#include "edge_mcl/localization/objects/object_follower.h"

#include <algorithm>
#include <cmath>

namespace edge_mcl {

namespace {

/// A group continues an object that was seen at most this long ago. Later it is known again. s
constexpr double kRecent = 0.5;
/// The same for images that come slowly, when the one before has shown it, s.
constexpr double kSlowImages = 1.2;
/// An object that was seen once or twice is forgotten after this time, s.
constexpr double kForgetUnproven = 1;
/// Most objects. The ones out of view for longest are forgotten. A building with more of them needs
/// a new model.
constexpr size_t kMost = 500;

/// Noise of a measured middle, per axis (m), and of the acceleration of people (m/s^2): they start
/// and stop within a second.
constexpr double kMiddleSigma = 0.05, kAcceleration = 2;
/// Standard deviation of the middle that comes from the hidden back, as a share of the depth: a
/// body is between a half and twice as deep as guessed.
constexpr double kHidden = 0.2;
/// Velocity of an object that is seen for the first time, m/s.
constexpr double kStartSpeed = 0.7;

/// The surface is compared with the one of this long ago, s.
constexpr double kBefore = 0.8, kSurfaces = 1.3;
/// Places of it that are compared: enough for a share within a few hundredths.
constexpr size_t kCompared = 150;
/// Places that are asked whether they are empty.
constexpr size_t kAskedPlaces = 50;
/// A place is still surface when a point lies within this distance, m.
constexpr double kSamePlace = 0.12;
/// An object moves when it is faster than this (m/s) and less of its surface is where it was. It
/// stands still when more is.
constexpr double kSlow = 0.2, kMovedShare = 0.6, kStillShare = 0.75;
/// Weight of one image in the smoothed share.
constexpr double kSmoothing = 0.3;

/// A place belongs to a box when so many images have shown it. More than the larger number do not
/// count, so that a place that becomes empty goes within a few images.
constexpr int kSeenPlace = 2, kMostSeen = 8;
/// Depth behind a place by more than this means that it is empty, m.
constexpr double kBehind = 0.15;
/// Share of the places in view that must be empty, and images in a row, until an object has gone.
constexpr double kEmptyShare = 0.7;
constexpr int kEmptyImages = 3;
/// Objects whose lower end is out of view stand on the floor, when it is at most so far below, m.
constexpr double kToFloor = 1.2;

bool hasPointNear(const PointCluster& cluster, const Eigen::Vector3f& place) {
  constexpr auto kSquare = static_cast<float>(kSamePlace * kSamePlace);
  return std::any_of(cluster.begin(), cluster.end(), [&](const VoxelPoint& v) {
    return (v.point - place).squaredNorm() < kSquare;
  });
}

/// @return the appearance in the first image that shows the object
Appearance appearanceIn(const PointCluster& cluster, const std::vector<ForeignColour>& colours) {
  for (const ForeignColour& view : colours) {
    Appearance appearance = appearanceOf(cluster, view);
    if (!appearance.empty()) return appearance;
  }
  return {};
}

void standOnFloor(const RayScene& scene, Eigen::AlignedBox3d* box) {
  const Eigen::Vector3f from(static_cast<float>(box->center().x()),
                             static_cast<float>(box->center().y()),
                             static_cast<float>(box->center().z()));
  const auto half = static_cast<float>(box->sizes().z() / 2);
  const auto hit = firstHit(scene.get(), from, -Eigen::Vector3f::UnitZ(), 0,
                            half + static_cast<float>(kToFloor));
  if (hit) box->min().z() = std::min(box->min().z(), static_cast<double>(from.z() - hit->along));
}

}  // namespace

void ObjectFollower::forget() { tracks_.clear(); }

std::vector<ObjectState> ObjectFollower::objects(double time) const {
  std::vector<ObjectState> found;
  for (const Track& track : tracks_) {
    if (track.object.number <= 0 || track.is_gone) continue;
    found.push_back(track.object);
    ObjectState& object = found.back();
    const double passed = std::max(0.0, time - object.last_seen);
    object.is_in_view = object.is_in_view && passed <= kSlowImages;
    if (isFollowed(track, time)) continue;
    object.velocity.setZero();
    if (track.has_moved) object.position_sigma += kWalking * passed;
  }
  std::sort(found.begin(), found.end(),
            [](const auto& a, const auto& b) { return a.number < b.number; });
  return found;
}

bool ObjectFollower::isFollowed(const Track& track, double time) {
  const double passed = time - track.object.last_seen;
  return passed <= (track.object.is_in_view ? kSlowImages : kRecent) && !track.is_gone;
}

void ObjectFollower::predict(Track* track, double time) {
  const double dt = std::max(0.0, time - track->filtered_at);
  track->filtered_at = time;
  if (!isFollowed(*track, time)) return;  // an object out of view stays where it is
  Eigen::Matrix2d step;
  step << 1, dt, 0, 1;
  track->middle += dt * track->velocity;
  const double q = kAcceleration * kAcceleration;
  Eigen::Matrix2d noise;
  noise << dt * dt * dt * dt / 4, dt * dt * dt / 2, dt * dt * dt / 2, dt * dt;
  track->variance = step * track->variance * step.transpose() + q * noise;
  if (!track->object.is_moving) return;
  track->object.box.translate(dt * track->velocity);
  track->newest.translate(dt * track->velocity);
}

void ObjectFollower::filterMiddle(const Eigen::Vector3d& measured, Track* track) {
  const double innovation = track->variance(0, 0) + kMiddleSigma * kMiddleSigma;
  const Eigen::Vector2d gain = track->variance.col(0) / innovation;
  const Eigen::Vector3d off = measured - track->middle;
  track->middle += gain[0] * off;
  track->velocity += gain[1] * off;
  track->variance -= (gain * track->variance.row(0)).eval();
}

void ObjectFollower::update(double time, const std::vector<ForeignDepth>& depths,
                            const std::vector<ForeignColour>& colours, const RayScene* scene,
                            const DepthParameters& params) {
  for (Track& track : tracks_) {
    predict(&track, time);
    // Out of view only the newest places are needed, to see whether they are empty.
    if (!isFollowed(track, time) && track.surfaces.size() > 1)
      track.surfaces.erase(track.surfaces.begin(), track.surfaces.end() - 1);
  }
  for (const ForeignDepth& view : depths) see(time, view, colours, scene, params);
  giveNumbers(time);
  for (Track& track : tracks_) track.object.is_in_view = track.object.last_seen == time;
  noteEmptyPlaces(time, depths, params);
  forgetOld(time);
}

void ObjectFollower::see(double time, const ForeignDepth& view,
                         const std::vector<ForeignColour>& colours, const RayScene* scene,
                         const DepthParameters& params) {
  std::vector<Eigen::Vector3f> points;
  points.reserve(view.foreign.points.size());
  for (const Eigen::Vector3f& p : view.foreign.points)
    points.emplace_back((view.T_map_depth * p.cast<double>()).cast<float>());
  std::vector<PointCluster> clusters = clustersOf(
      voxelsOf(points), neighboursOf(view.foreign.points, view.image.camera, view.foreign.spacing));
  std::vector<PointCluster> apart;
  std::map<size_t, PointCluster> parts = continued(time, &clusters, &apart);
  for (const PointCluster& cluster : apart) {
    const Eigen::AlignedBox3d box = boxOf(cluster);
    for (Track& track : tracks_)
      for (auto it = track.places.begin(); it != track.places.end();)
        it = box.contains(it->second.point.cast<double>()) ? track.places.erase(it) : std::next(it);
    tracks_.push_back(begun(time, ObjectSide(cluster, view)));
    parts[tracks_.size() - 1] = cluster;
  }
  for (const PointCluster& cluster : clusters) {
    if (!isLarge(cluster)) continue;
    size_t known = standingAt(cluster);
    if (known == tracks_.size()) tracks_.push_back(begun(time, ObjectSide(cluster, view)));
    if (!isFollowed(tracks_[known], time)) tracks_[known].surfaces.clear();
    parts[known] = joined(std::move(parts[known]), cluster);
  }
  for (const auto& [track, cluster] : parts)
    add(time, cluster, view, colours, scene, params, &tracks_[track]);
}

ObjectFollower::Track ObjectFollower::begun(double time, const ObjectSide& side) {
  Track track;
  track.object.first_seen = track.object.last_seen = track.object.still_since = time;
  track.filtered_at = time;
  track.middle = side.middle(side.learn(std::nullopt));
  track.variance =
      Eigen::Vector2d(kMiddleSigma * kMiddleSigma, kStartSpeed * kStartSpeed).asDiagonal();
  return track;
}

void ObjectFollower::judgeMotion(double time, const PointCluster& cluster, const ForeignDepth& view,
                                 const DepthParameters& params, Track* track) {
  std::deque<Surface>& surfaces = track->surfaces;
  while (!surfaces.empty() && surfaces.front().time < time - kSurfaces) surfaces.pop_front();
  const auto before = std::find_if(surfaces.rbegin(), surfaces.rend(), [&](const Surface& surface) {
    return surface.time <= time - kBefore;
  });
  ObjectState& object = track->object;
  if (before != surfaces.rend()) {
    track->is_judged = true;
    double kept = 0, asked = 0;
    const Eigen::AlignedBox3d newest = boxOf(cluster);
    const Eigen::Vector3d margin = Eigen::Vector3d::Constant(kSamePlace);
    const Eigen::AlignedBox3d box(newest.min() - margin, newest.max() + margin);
    const size_t step = std::max<size_t>(1, before->points.size() / kCompared);
    for (size_t i = 0; i < before->points.size(); i += step) {
      const VoxelPoint& v = before->points[i];
      const bool is_kept = hasPointNear(cluster, v.point);
      const Sight sight = lookAt(view, v.point.cast<double>(), kBehind, params);
      // An object that comes nearer hides its old places itself.
      const bool is_hidden =
          sight.kind == Sight::Kind::kHidden && box.squaredExteriorDistance(sight.surface) > 0;
      if (!is_kept && (is_hidden || sight.kind == Sight::Kind::kUnknown)) continue;
      ++asked;
      kept += is_kept;
    }
    if (asked > 0) track->kept_share += kSmoothing * (kept / asked - track->kept_share);
    const bool was_moving = object.is_moving;
    if (track->velocity.norm() > kSlow && track->kept_share < kMovedShare)
      object.is_moving = track->has_moved = true;
    if (track->kept_share > kStillShare) object.is_moving = false;
    if (was_moving && !object.is_moving) object.still_since = time;
  }
  surfaces.push_back({time, cluster});
}

void ObjectFollower::collect(const PointCluster& cluster, const ForeignDepth& view,
                             const DepthParameters& params, Track* track) {
  std::map<int64_t, Place>& places = track->places;
  for (const VoxelPoint& v : cluster) {
    Place& place = places.try_emplace(v.key, Place{v.point, 0}).first->second;
    place.seen = std::min(place.seen + 1, kMostSeen);
    place.point += (v.point - place.point) / static_cast<float>(place.seen);
  }
  for (auto it = places.begin(); it != places.end();) {
    const bool is_empty =
        lookAt(view, it->second.point.cast<double>(), kBehind, params).kind == Sight::Kind::kFree;
    if (is_empty) it->second.seen -= 2;
    it = is_empty && it->second.seen <= 0 ? places.erase(it) : std::next(it);
  }
}

void ObjectFollower::add(double time, const PointCluster& cluster, const ForeignDepth& view,
                         const std::vector<ForeignColour>& colours, const RayScene* scene,
                         const DepthParameters& params, Track* track) {
  const ObjectSide side(cluster, view);
  track->size = side.learn(track->size);
  filterMiddle(side.middle(*track->size), track);
  judgeMotion(time, cluster, view, params, track);
  ObjectState& object = track->object;
  const Appearance appearance = appearanceIn(cluster, colours);
  if (track->appearance.empty()) track->appearance = appearance;
  for (size_t i = 0; i < appearance.size(); ++i)
    track->appearance[i] += static_cast<float>(kSmoothing) * (appearance[i] - track->appearance[i]);
  PointCluster sure;
  if (object.is_moving) {
    track->places.clear();
  } else {
    collect(cluster, view, params, track);
    for (const auto& [key, place] : track->places)
      if (place.seen >= kSeenPlace) sure.push_back({key, place.point, place.seen, 0});
  }
  object.box =
      sure.empty() || !track->is_judged ? side.boxAround(track->middle, *track->size) : boxOf(sure);
  if (scene && side.isCutBelow()) standOnFloor(*scene, &object.box);
  track->newest = boxOf(cluster);
  object.velocity = object.is_moving ? track->velocity : Eigen::Vector3d::Zero();
  object.position_sigma = std::hypot(std::sqrt(track->variance(0, 0)), kHidden * (*track->size)[1]);
  if (object.last_seen < time || track->sightings == 0) ++track->sightings;
  object.last_seen = time;
  track->empty = 0;
}

void ObjectFollower::noteEmptyPlaces(double time, const std::vector<ForeignDepth>& depths,
                                     const DepthParameters& params) {
  for (Track& track : tracks_) {
    if (track.object.last_seen == time || track.is_gone || track.surfaces.empty()) continue;
    double in_view = 0, empty = 0;
    const PointCluster& last = track.surfaces.back().points;
    const size_t step = std::max<size_t>(1, last.size() / kAskedPlaces);
    double asked = 0;
    for (size_t i = 0; i < last.size(); i += step, ++asked)
      for (const ForeignDepth& view : depths) {
        const Eigen::Vector3d place = last[i].point.cast<double>();
        const Sight::Kind sight = lookAt(view, place, kBehind, params).kind;
        in_view += sight == Sight::Kind::kThere || sight == Sight::Kind::kFree;
        empty += sight == Sight::Kind::kFree;
      }
    constexpr double kLeastInView = 0.3;
    if (in_view < kLeastInView * asked) continue;
    track.empty = empty > kEmptyShare * in_view ? track.empty + 1 : 0;
    track.is_gone = track.empty >= kEmptyImages;
  }
}

void ObjectFollower::forgetOld(double time) {
  const auto isOld = [&](const Track& track) {
    const double passed = time - track.object.last_seen;
    if (track.object.number == 0) return passed > kForgetUnproven;
    return (track.is_gone || track.has_moved) && passed > kRemember;
  };
  tracks_.erase(std::remove_if(tracks_.begin(), tracks_.end(), isOld), tracks_.end());
  while (tracks_.size() > kMost)
    tracks_.erase(std::min_element(
        tracks_.begin(), tracks_.end(),
        [](const Track& a, const Track& b) { return a.object.last_seen < b.object.last_seen; }));
}

}  // namespace edge_mcl
