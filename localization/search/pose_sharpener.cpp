#include "edge_mcl/localization/search/pose_sharpener.h"

#include <algorithm>
#include <cmath>

#include "edge_mcl/core/likelihood/cpu_backend.h"

namespace edge_mcl {

namespace {

// Score of an explained contour pixel in an image that is kContourWidth pixels wide. With this
// score a long contour counts about as much as the model line that lies on it.
constexpr double kNatsPerContourPixel = 0.2, kContourWidth = 640;
// Cost of a pixel of a visible model edge without image edge, as a share of the score of an
// explained pixel. Images do not show every edge of the model. With this share a pose still gains
// when the image shows more than a third of its visible edges.
constexpr double kShareOfMissingPixel = 0.5;

}  // namespace

bool isNear(const Pose& a, const Pose& b, double distance, double angle) {
  return (a.translation() - b.translation()).squaredNorm() < distance * distance &&
         rotationAngle(a, b) < angle;
}

std::shared_ptr<const VisibleSet> visibleInView(const Visibility& visibility,
                                                const Pose& T_map_camera, const CameraModel& camera,
                                                uint32_t thinning) {
  const ViewCone cone{T_map_camera.linear().col(2).cast<float>(),
                      static_cast<float>(camera.view.angle + kTurnInView)};
  return std::make_shared<const VisibleSet>(
      visibility.exact(T_map_camera.translation(), thinning, cone));
}

PoseSharpener::PoseSharpener(const LocalizationMap& map)
    : map_(map),
      thinning_(SearchPlaces::thinningTo(map.edges(), 6000)),
      refiner_(map.params().refinement, map.params().likelihood, map.params().image) {
  if (map.depth()) refiner_.setDepth(map.sharedDepth());
}

std::shared_ptr<const VisibleSet> PoseSharpener::visibleFrom(const Pose& base,
                                                             const CameraView& view) const {
  return visibleInView(map_.visibility(), base * view.T_base_camera, view.image->frame.camera,
                       thinning_);
}

std::vector<RefinementView> PoseSharpener::viewsFrom(const SearchViews& seen,
                                                     const Pose& base) const {
  std::vector<RefinementView> refined;
  for (const CameraView& view : seen.views) {
    RefinementView r;
    r.T_base_camera = view.T_base_camera;
    r.depth = view.depth.get();
    if (view.image) {
      r.camera = &view.image->frame.camera;
      r.image = &view.image->edges;
      r.pixels = &view.image->pixels;
      r.pixel_scale = view.image->pixel_scale;
      r.visible = visibleFrom(base, view);
    }
    refined.push_back(std::move(r));
  }
  return refined;
}

FoundPose PoseSharpener::sharpen(const SearchViews& seen, const Pose& start,
                                 const PoseGaussian& prior) const {
  const std::vector<CameraView>& views = seen.views;
  std::vector<RefinementView> refined = viewsFrom(seen, start);
  const RefinementParameters& p = map_.params().refinement;
  const RefinementResult result =
      refiner_.refine(refined, start, prior, {p.iterations, p.start_samples});
  FoundPose found;
  found.pose = result.pose;
  found.covariance = result.covariance;
  const bool has_image = std::any_of(views.begin(), views.end(),
                                     [](const CameraView& v) { return v.image != nullptr; });
  if (has_image)
    found.match_ratio =
        static_cast<double>(result.matched_samples) / std::max(1, result.used_samples);
  const LikelihoodParameters& tracking = map_.params().likelihood;
  const LikelihoodParameters searching = searchLikelihood(map_.params());
  double line_scores = 0, lines = 0, points = 0, on_model = 0;
  double contours = 0;  // explained pixels minus weighted missing pixels
  size_t explained = 0, pixels = 0;
  double widest = kContourWidth;
  for (size_t v = 0; v < views.size(); ++v) {
    const Pose camera = found.pose * views[v].T_base_camera;
    if (views[v].image) {
      LikelihoodFrame frame = views[v].image->frame;
      // The visible sets are thinned already, so their samples are farther apart.
      frame.sample_step *= thinning_;
      constexpr double kMoved = 0.05;  // m; after a longer way other samples are hidden
      if (!isNear(found.pose, start, kMoved, kTurnInView))
        refined[v].visible = visibleFrom(found.pose, views[v]);
      const PoseScore s = evaluateWithVisibleSet(frame, *refined[v].visible, {camera}).front();
      const auto count = static_cast<double>(s.line_count);
      const double of_image = scorePerLine(tracking, s.log_likelihood, count) * count;
      found.log_likelihood += tracking.model == LikelihoodModel::kRobust
                                  ? combineLines(searching, of_image, count)
                                  : s.log_likelihood;
      line_scores += of_image;
      lines += count;
      widest = std::max(widest, static_cast<double>(frame.camera.width));
      const ContourMatch match =
          seen.contours[v]->compare(*refined[v].visible, frame.camera, camera, frame.sample_step);
      contours += static_cast<double>(match.explained) -
                  kShareOfMissingPixel * static_cast<double>(match.missing);
      explained += match.explained;
      pixels += seen.contours[v]->size();
    }
    if (views[v].depth && map_.depth()) {
      const DepthScore s = map_.depth()->evaluate(*views[v].depth, {camera}).front();
      found.log_likelihood += s.log_likelihood;
      points += static_cast<double>(views[v].depth->count);
      on_model += static_cast<double>(views[v].depth->count) * static_cast<double>(s.agreement);
    }
  }
  found.evidence = lines > 0 ? line_scores / lines : 0;
  found.log_likelihood += kNatsPerContourPixel * kContourWidth / widest * contours;
  if (pixels > 0)
    found.contour_share = static_cast<double>(explained) / static_cast<double>(pixels);
  if (points > 0) found.depth_agreement = on_model / points;
  return found;
}

}  // namespace edge_mcl
