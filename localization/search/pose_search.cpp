#include "edge_mcl/localization/search/pose_search.h"
#include "edge_mcl/core/base/angles.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/edges/main_directions.h"
#include "edge_mcl/core/likelihood/cpu_backend.h"
#include "edge_mcl/localization/filter/mode_proposal.h"
#include "edge_mcl/localization/lookup/place_lookup.h"

namespace edge_mcl {

namespace {

// Effort of a refinement in the reduced image: iterations, samples per camera.
constexpr RefinementEffort kReducedEffort{6, 200};

/// Random R_map_base of a base whose camera is held roughly upright. @param heading radians.
Eigen::Matrix3d uprightRotation(double heading, const Pose& T_base_camera, RandomSource* random) {
  constexpr double kPitch = 20 * kDegree, kRoll = 8 * kDegree;  // standard deviations
  const Eigen::Matrix3d camera =
      Eigen::AngleAxisd(heading, Eigen::Vector3d::UnitZ()) * opticalOnBody().linear() *
      Eigen::AngleAxisd(kPitch * random->normal(), Eigen::Vector3d::UnitX()) *
      Eigen::AngleAxisd(kRoll * random->normal(), Eigen::Vector3d::UnitZ());
  return camera * T_base_camera.linear().transpose();
}

/// R_map_base with roll and pitch from a reading, turned to a heading. @param heading radians.
/// @param certain a reading with a larger sigma (rad) gets random noise of that sigma.
Eigen::Matrix3d levelRotation(const UpReading& up, double heading, double certain,
                              RandomSource* random) {
  const Eigen::Matrix3d level =
      Eigen::Quaterniond::FromTwoVectors(up.up_base, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  Eigen::Matrix3d tilt = Eigen::Matrix3d::Identity();
  if (up.sigma > certain)
    tilt = expSo3(up.sigma * Eigen::Vector3d(random->normal(), random->normal(), 0));
  return Eigen::AngleAxisd(heading, Eigen::Vector3d::UnitZ()) * tilt * level;
}

/// T_map_base that puts the camera at a position. @param rotation R_map_base.
Pose baseAt(const Eigen::Vector3d& camera_position, const Eigen::Matrix3d& rotation,
            const Pose& T_base_camera) {
  Pose pose = Pose::Identity();
  pose.linear() = rotation;
  pose.translation() = camera_position - rotation * T_base_camera.translation();
  return pose;
}

RefinementView reducedView(const Pose& T_base_camera,
                           const std::shared_ptr<const SmallImage>& small,
                           std::shared_ptr<const VisibleSet> visible) {
  RefinementView view;
  view.T_base_camera = T_base_camera;
  if (!small) return view;
  view.camera = &small->camera;
  view.image = &small->edges;
  view.pixels = &small->pixels;
  view.visible = std::move(visible);
  return view;
}

/// Leaves out items near a better one, and keeps at most `most`. @param items best first.
/// @param distance, angle items closer than both limits are near each other: metres, radians.
template <class Item>
std::vector<Item> distinct(std::vector<Item> items, size_t most, double distance, double angle) {
  std::vector<Item> kept;
  for (Item& item : items) {
    if (kept.size() >= most) break;
    const bool fresh = std::none_of(kept.begin(), kept.end(), [&](const Item& k) {
      return isNear(k.pose, item.pose, distance, angle);
    });
    if (fresh) kept.push_back(std::move(item));
  }
  return kept;
}

/// Positions within a cube of this side: a grid of three in each direction.
std::vector<Eigen::Vector3d> positionsInCell(double side) {
  std::vector<Eigen::Vector3d> steps;
  for (const int x : {-1, 0, 1})
    for (const int y : {-1, 0, 1})
      for (const int z : {-1, 0, 1}) steps.emplace_back(side / 3 * Eigen::Vector3d(x, y, z));
  return steps;
}

/// Which places count: those in the region, and at least those around its centre.
/// @param spacing of the places, m.
std::function<bool(const Eigen::Vector3d&)> filterOf(const std::optional<SearchRegion>& region,
                                                     double spacing) {
  if (!region) return nullptr;
  return [centre = region->centre, radius = std::max(region->radius, spacing)](
             const Eigen::Vector3d& p) { return (p - centre).norm() <= radius; };
}

}  // namespace

SearchRegion SearchRegion::around(const PoseGaussian& guess) {
  constexpr double kSigmas = 3, kMounting = 0.5;  // m from the base to a camera
  const double sigma = std::sqrt(guess.covariance.topLeftCorner<3, 3>().diagonal().maxCoeff());
  return {guess.mean.translation(), kSigmas * sigma + kMounting};
}

PoseSearch::PoseSearch(const LocalizationMap& map)
    : map_(map),
      small_thinning_(SearchPlaces::thinningFor(map.edges())),
      small_images_(map.params(), map.params().search.small_width, map.edges().sample_step,
                    small_thinning_),
      sharpener_(map),
      space_(map.freeSpace()),
      directions_(mainDirections(map.edges())) {}

PoseSearch::SmallViews PoseSearch::reduce(const std::vector<CameraView>& views) const {
  SmallViews small;
  for (const CameraView& view : views)
    small.push_back(view.image ? small_images_.make(*view.image) : nullptr);
  return small;
}

void PoseSearch::score(const std::vector<CameraView>& views, const SmallViews& small, bool sharp,
                       const std::shared_ptr<const VisibleSet>& visible,
                       const std::vector<Pose>& poses, double* scores) const {
  std::fill(scores, scores + poses.size(), 0.0);
  for (size_t v = 0; v < views.size(); ++v) {
    std::vector<Pose> cameras(poses);
    for (Pose& pose : cameras) pose = pose * views[v].T_base_camera;
    if (small[v]) {
      const std::vector<PoseScore> s =
          evaluateWithVisibleSet(sharp ? small[v]->sharp : small[v]->broad, *visible, cameras);
      for (size_t i = 0; i < poses.size(); ++i) scores[i] += s[i].log_likelihood;
    }
    if (views[v].depth && map_.depth()) {
      const std::vector<DepthScore> s = map_.depth()->evaluate(*views[v].depth, cameras);
      for (size_t i = 0; i < poses.size(); ++i) scores[i] += s[i].log_likelihood;
    }
  }
}

bool PoseSearch::admits(const std::vector<CameraView>& views, const Pose& pose) const {
  return std::all_of(views.begin(), views.end(), [&](const CameraView& view) {
    return space_->admits((pose * view.T_base_camera).translation());
  });
}

PoseGaussian PoseSearch::looseAround(const Pose& start, const std::optional<UpReading>& up) const {
  PoseGaussian prior;
  constexpr double kStart = 0.4;  // m; about the distance between search places
  prior.mean = start;
  prior.covariance.diagonal().head<3>().setConstant(kStart * kStart);
  const double turn = 20 * kDegree;
  prior.covariance.diagonal().tail<3>().setConstant(turn * turn);
  if (!up) return prior;
  const double sigma = std::max(up->sigma, map_.params().search.tilt_sigma_deg * kDegree);
  const Eigen::Vector3d u = up->up_base.normalized();
  prior.mean.linear() = start.linear() * expSo3(tiltError(start, u));
  const Eigen::Matrix3d about_up = u * u.transpose();
  prior.covariance.bottomRightCorner<3, 3>() =
      turn * turn * about_up + sigma * sigma * (Eigen::Matrix3d::Identity() - about_up);
  return prior;
}

std::vector<Pose> PoseSearch::finish(const std::vector<CameraView>& views, const SmallViews& small,
                                     std::vector<Start> starts,
                                     const std::optional<UpReading>& up) const {
  const SearchParameters& p = map_.params().search;
  const auto better = [](const auto& a, const auto& b) { return a.score > b.score; };
  std::stable_sort(starts.begin(), starts.end(), better);
  if (starts.size() > static_cast<size_t>(p.refined)) starts.resize(p.refined);
  tbb::parallel_for(size_t{0}, starts.size(), [&](size_t i) {
    Start& start = starts[i];
    std::vector<RefinementView> refined;
    for (size_t v = 0; v < views.size(); ++v)
      refined.push_back(reducedView(views[v].T_base_camera, small[v], start.visible));
    const PoseGaussian prior = looseAround(start.pose, up);
    start.pose = small_images_.refiner().refine(refined, prior.mean, prior, kReducedEffort).pose;
    score(views, small, true, start.visible, {start.pose}, &start.score);
    start.admitted = admits(views, start.pose);
  });
  starts.erase(std::remove_if(starts.begin(), starts.end(),
                              [](const Start& start) { return !start.admitted; }),
               starts.end());
  std::stable_sort(starts.begin(), starts.end(), better);
  starts = distinct(std::move(starts), 2 * static_cast<size_t>(p.hypotheses), 0.12, 4 * kDegree);

  std::vector<Pose> found;
  found.reserve(starts.size());
  for (const Start& start : starts) found.push_back(start.pose);
  return found;
}

std::vector<Pose> PoseSearch::lookedUp(const std::vector<CameraView>& views,
                                       const std::optional<UpReading>& up,
                                       const std::optional<SearchRegion>& region) {
  if (!uses_lookup_) return {};
  if (!prepared_) prepared_ = map_.preparedPlaces();
  const auto view = std::find_if(views.begin(), views.end(),
                                 [](const CameraView& v) { return v.image != nullptr; });
  if (!prepared_ || view == views.end()) return {};
  const Pose& T_base_camera = view->T_base_camera;
  KnownUp known;
  if (up) {
    known.up_camera = T_base_camera.linear().transpose() * up->up_base;
    known.sigma = std::max(up->sigma, map_.params().search.tilt_sigma_deg * kDegree);
  }
  const std::vector<LookupPose> poses = lookUp(
      *prepared_, view->image->edges, view->image->frame.camera, known,
      static_cast<size_t>(map_.params().search.candidates), filterOf(region, prepared_->spacing()));
  const SmallViews small = reduce(views);
  const CameraModel& camera = small[static_cast<size_t>(view - views.begin())]->camera;
  // A refinement from half the distance between places away often fails. So some positions around
  // each place are compared first, with the lines that are visible from the place.
  std::vector<Start> starts(poses.size());
  tbb::parallel_for(size_t{0}, poses.size(), [&](size_t i) {
    const Pose& T_map_camera = poses[i].T_map_camera;
    starts[i].visible = visibleInView(map_.visibility(), T_map_camera, camera, small_thinning_);
    std::vector<Pose> around;
    for (const Eigen::Vector3d& step : positionsInCell(prepared_->spacing())) {
      Pose moved = T_map_camera;
      moved.translation() += step;
      around.push_back(normalized(moved * T_base_camera.inverse()));
    }
    std::vector<double> scores(around.size());
    score(views, small, false, starts[i].visible, around, scores.data());
    const auto best = std::max_element(scores.begin(), scores.end());
    starts[i].pose = around[static_cast<size_t>(best - scores.begin())];
    starts[i].score = *best;
  });
  return finish(views, small, std::move(starts), up);
}

std::vector<Pose> PoseSearch::everywhere(const std::vector<CameraView>& views,
                                         const std::optional<UpReading>& up, RandomSource* random,
                                         const std::optional<SearchRegion>& region) {
  const SearchParameters& p = map_.params().search;
  if (!places_) places_ = map_.searchPlaces();
  // Without a limit, many orientations at very many places would take minutes.
  constexpr size_t kMostPoses = 400000;
  const auto headings = static_cast<size_t>(p.headings);
  const size_t per_place =
      up ? headings
         : std::min(static_cast<size_t>(p.orientations),
                    std::max(headings, kMostPoses / std::max<size_t>(1, places_->places.size())));
  const auto rotationOf = [&](size_t i, double phase, RandomSource* own) -> Eigen::Matrix3d {
    // Stratified sampling: one pose in every part of space and heading, at a random point of it.
    const double heading =
        2 * M_PI * (static_cast<double>(i) + phase) / static_cast<double>(per_place);
    return up ? levelRotation(*up, heading, p.tilt_sigma_deg * kDegree, own)
              : uprightRotation(heading, views.front().T_base_camera, own);
  };
  return everywhere(views, up, per_place, random, rotationOf, region);
}

std::vector<Pose> PoseSearch::everywhere(const std::vector<CameraView>& views,
                                         const std::optional<UpReading>& up,
                                         const std::vector<Eigen::Matrix3d>& rotations,
                                         RandomSource* random) {
  constexpr size_t kPositions = 4;
  return everywhere(views, up, kPositions * rotations.size(), random,
                    [&](size_t i, double, RandomSource*) { return rotations[i / kPositions]; });
}

std::vector<Pose> PoseSearch::everywhere(
    const std::vector<CameraView>& views, const std::optional<UpReading>& up, size_t per_place,
    RandomSource* random,
    const std::function<Eigen::Matrix3d(size_t, double, RandomSource*)>& rotationOf,
    const std::optional<SearchRegion>& region) {
  if (!places_) places_ = map_.searchPlaces();
  const std::vector<SearchPlaces::Place>& places = places_->places;
  const SearchParameters& p = map_.params().search;
  const SmallViews small = reduce(views);
  // Every place has its own random source, so that the result does not depend on the threads.
  std::vector<uint64_t> seeds(places.size());
  for (uint64_t& seed : seeds) seed = static_cast<uint64_t>(random->uniform() * 0x1.0p53);
  const size_t kept =
      std::max<size_t>(4, (2 * static_cast<size_t>(p.refined) + places.size() - 1) / places.size());
  std::vector<std::vector<Start>> of_place(places.size());
  const auto counts = filterOf(region, places_->spacing);
  tbb::parallel_for(size_t{0}, places.size(), [&](size_t k) {
    RandomSource own(seeds[k]);
    const SearchPlaces::Place& place = places[k];
    if (counts && !counts(place.position)) return;
    std::vector<Pose> poses;
    const double phase = own.uniform();
    for (size_t i = 0; i < per_place; ++i) {
      Eigen::Vector3d position = place.position;
      for (int a = 0; a < 3; ++a) position[a] += places_->spacing * 0.6 * (own.uniform() - 0.5);
      poses.push_back(baseAt(position, rotationOf(i, phase, &own), views.front().T_base_camera));
    }
    // Poses with neighbouring headings are scored together. The kernel then leaves out the segments
    // behind all of them.
    std::vector<double> scores(poses.size());
    constexpr size_t kTogether = 16;
    for (size_t i = 0; i < poses.size(); i += kTogether)
      score(views, small, false, place.visible,
            {poses.begin() + static_cast<long>(i),
             poses.begin() + static_cast<long>(std::min(i + kTogether, poses.size()))},
            &scores[i]);
    std::vector<size_t> order(poses.size());
    std::iota(order.begin(), order.end(), size_t{0});
    std::stable_sort(order.begin(), order.end(),
                     [&](size_t a, size_t b) { return scores[a] > scores[b]; });
    for (size_t i = 0; i < std::min(kept, order.size()); ++i)
      of_place[k].push_back({poses[order[i]], place.visible, scores[order[i]]});
  });
  std::vector<Start> starts;
  for (std::vector<Start>& s : of_place) starts.insert(starts.end(), s.begin(), s.end());
  return finish(views, small, std::move(starts), up);
}

std::vector<Pose> PoseSearch::around(const std::vector<CameraView>& views,
                                     const PoseGaussian& guess, const std::optional<UpReading>& up,
                                     RandomSource* random) {
  constexpr size_t kPlaces = 150, kPerPlace = 10;
  const SmallViews small = reduce(views);
  const GaussianDensity density(guess);
  std::vector<Start> starts(kPlaces * kPerPlace);
  for (size_t k = 0; k < kPlaces; ++k) {
    const Pose first = density.draw(random);
    const Eigen::Vector3d camera = (first * views.front().T_base_camera).translation();
    for (size_t i = 0; i < kPerPlace; ++i) {
      const Pose drawn = density.draw(random);
      starts[k * kPerPlace + i].pose = baseAt(camera, drawn.linear(), views.front().T_base_camera);
    }
  }
  tbb::parallel_for(size_t{0}, kPlaces, [&](size_t k) {
    std::vector<Pose> poses;
    const size_t begin = k * kPerPlace;
    for (size_t i = 0; i < kPerPlace; ++i) poses.push_back(starts[begin + i].pose);
    const auto visible = std::make_shared<const VisibleSet>(map_.visibility().exact(
        (poses.front() * views.front().T_base_camera).translation(), small_thinning_));
    std::vector<double> scores(kPerPlace);
    score(views, small, false, visible, poses, scores.data());
    for (size_t i = 0; i < kPerPlace; ++i) {
      starts[begin + i].visible = visible;
      starts[begin + i].score = scores[i];
    }
  });
  return finish(views, small, std::move(starts), up);
}

std::vector<Pose> PoseSearch::alike(const SearchViews& seen, const Pose& pose) const {
  // A pose with an error of half a step is still within reach of a refinement in the reduced image.
  // Each pose needs a visible set of its own. Near beams and columns a neighbouring search place
  // sees other lines.
  constexpr double kStep = 0.2, kNearest = 0.4;  // m
  constexpr size_t kMost = 12;
  const auto image = static_cast<size_t>(std::find_if(seen.small.begin(), seen.small.end(),
                                                      [](const auto& s) { return s != nullptr; }) -
                                         seen.small.begin());
  if (image == seen.small.size()) return {};
  const Pose& T_base_camera = seen.views[image].T_base_camera;
  const Eigen::Vector3d low = map_.mesh().lowest.cast<double>(),
                        high = map_.mesh().highest.cast<double>();
  const auto isInside = [&](const Eigen::Vector3d& p) {
    return (p.array() >= low.array()).all() && (p.array() <= high.array()).all();
  };
  std::vector<Start> starts;
  for (const Eigen::Vector3d& direction : directions_)
    for (const double sign : {-1.0, 1.0})
      for (double way = kNearest;; way += kStep) {
        Start start;
        start.pose = pose;
        start.pose.pretranslate(sign * way * direction);
        if (!isInside((start.pose * T_base_camera).translation())) break;
        starts.push_back(start);
      }
  tbb::parallel_for(size_t{0}, starts.size(), [&](size_t i) {
    Start& start = starts[i];
    start.admitted = admits(seen.views, start.pose);
    if (!start.admitted) return;
    const auto visible = visibleInView(map_.visibility(), start.pose * T_base_camera,
                                       seen.small[image]->camera, small_thinning_);
    score(seen.views, seen.small, false, visible, {start.pose}, &start.score);
  });
  starts.erase(std::remove_if(starts.begin(), starts.end(),
                              [](const Start& start) { return !start.admitted; }),
               starts.end());
  std::stable_sort(starts.begin(), starts.end(),
                   [](const Start& a, const Start& b) { return a.score > b.score; });
  std::vector<Pose> found;
  for (const Start& start : distinct(std::move(starts), kMost, kNearest, kDegree))
    found.push_back(start.pose);
  return found;
}

SearchViews PoseSearch::prepare(std::vector<CameraView> views) const {
  SearchViews seen;
  seen.small = reduce(views);
  for (const CameraView& view : views)
    seen.contours.push_back(view.image ? std::make_shared<const ImageContours>(view.image->edges)
                                       : nullptr);
  seen.views = std::move(views);
  return seen;
}

FoundPose PoseSearch::follow(const SearchViews& seen, const PoseGaussian& prior) const {
  std::vector<RefinementView> refined;
  for (size_t v = 0; v < seen.views.size(); ++v) {
    const Pose& T_base_camera = seen.views[v].T_base_camera;
    std::shared_ptr<const VisibleSet> visible;
    if (seen.small[v])
      visible = visibleInView(map_.visibility(), prior.mean * T_base_camera, seen.small[v]->camera,
                              small_thinning_);
    refined.push_back(reducedView(T_base_camera, seen.small[v], std::move(visible)));
  }
  const Pose start =
      small_images_.refiner().refine(refined, prior.mean, prior, kReducedEffort).pose;
  return sharpener_.sharpen(seen, start, prior);
}

}  // namespace edge_mcl
