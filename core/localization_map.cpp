#include "edge_mcl/core/localization_map.h"

#include <algorithm>
#include <bitset>
#include <chrono>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/edges/audit_table.h"
#include "edge_mcl/core/image/edge_field.h"
#include "edge_mcl/core/image/pixel_scale.h"
#include "edge_mcl/core/import/mesh_loader.h"

namespace edge_mcl {

LocalizationMap::LocalizationMap(const std::string& model_file, const Parameters& params)
    : params_(params) {
  params_.validate();
  mesh_ = std::make_unique<MeshModel>(loadMesh(model_file, params_.map));
  build(model_file);
  if (edges_->lines.empty() && usesImages())
    throw InputError(model_file +
                     ": the model has no feature edges (see map.crease_angle_deg, map.boundaries, "
                     "map.contours, map.confidence)");
}

LocalizationMap::LocalizationMap(MeshModel mesh, const Parameters& params) : params_(params) {
  params_.validate();
  mesh_ = std::make_unique<MeshModel>(std::move(mesh));
  build("");
}

void LocalizationMap::build(const std::string& model_file) {
  model_file_ = model_file;
  if (!params_.map.confidence.empty())
    leaveOutDoubted(readAuditTable(params_.map.confidence), params_.map.min_confidence,
                    mesh_.get());
  edges_ = std::make_unique<EdgeModel>(buildEdgeModel(mesh_.get(), params_.map));
  visibility_ = std::make_shared<Visibility>(*mesh_, *edges_, params_.visibility);
  backend_ = std::make_unique<CpuBackend>(visibility_);
  refiner_ = std::make_unique<PoseRefiner>(params_.refinement, params_.likelihood, params_.image);
  if (params_.likelihood.cues == Cues::kEdges) return;
  DistanceField::Options options;
  options.truncation = params_.depth.truncation;
  options.voxel_size = params_.depth.voxel_size;
  options.most_bytes = 1e6 * params_.depth.field_megabytes;
  std::string warning;
  auto field = std::make_shared<DistanceField>(
      params_.depth.store_field && !model_file.empty()
          ? storedDistanceField(*mesh_, options, model_file, &warning)
          : DistanceField(*mesh_, options));
  if (!warning.empty()) mesh_->report.warnings.push_back(warning);
  depth_ = std::make_shared<DepthLikelihood>(std::move(field), params_.depth);
  refiner_->setDepth(depth_);
}

std::shared_ptr<const DepthPoints> LocalizationMap::prepareDepth(const DepthImage& image) const {
  return std::make_shared<DepthPoints>(makeDepthPoints(image, params_.depth));
}

std::shared_ptr<const ScoreLevels> LocalizationMap::levelsFor(double pixel_scale) const {
  const std::lock_guard<std::mutex> lock(levels_->mutex);
  std::shared_ptr<const ScoreLevels>& levels = levels_->of_scale[pixel_scale];
  if (!levels)
    levels = std::make_shared<const ScoreLevels>(scaledBy(pixel_scale, params_.image),
                                                 scaledBy(pixel_scale, params_.likelihood));
  return levels;
}

std::shared_ptr<const PreparedImage> LocalizationMap::prepare(const CameraModel& camera,
                                                              const cv::Mat& image,
                                                              const cv::Mat& mask,
                                                              const std::string& origin) const {
  using Clock = std::chrono::steady_clock;
  const auto milliseconds = [](Clock::time_point a, Clock::time_point b) {
    return std::chrono::duration<double, std::milli>(b - a).count();
  };
  if (image.cols != camera.width || image.rows != camera.height)
    throw InputError(origin + ": the image has " + std::to_string(image.cols) + "x" +
                     std::to_string(image.rows) + " pixels, camera_info says " +
                     std::to_string(camera.width) + "x" + std::to_string(camera.height));
  ScoreTable::checkSize(image.cols, image.rows, params_.image.orientation_bins);
  const double scale = pixelScale(params_.image, image.size());
  const ImageParameters of_image = scaledBy(scale, params_.image);
  const std::shared_ptr<const ScoreLevels> levels = levelsFor(scale);
  auto prepared = std::make_shared<PreparedImage>();
  prepared->pixel_scale = scale;
  const auto t0 = Clock::now();
  cv::Mat grey = toGrey(image, origin);
  // The image is copied, because it is kept and may be read by another thread after the caller has
  // reused or freed its memory.
  if (grey.data == image.data) grey = grey.clone();
  const cv::Mat ignore = ignoredPixels(mask, grey.size(), of_image, origin);
  LikelihoodFrame& frame =
      prepared->frame = {camera, nullptr, scaledBy(scale, params_.likelihood), edges_->sample_step};
  const bool elsewhere = backend_->makesTables(of_image);
  if (elsewhere) {
    frame.picture = std::make_shared<Picture>(grey, ignore, of_image, levels);
    backend_->prefetch(frame);
  }
  prepared->edges = findEdgesOf(grey, ignore, of_image);
  prepared->pixels = EdgePixels(prepared->edges);
  const auto t1 = Clock::now();
  auto t2 = t1, t3 = t1;
  if (!elsewhere) {
    const EdgeField field(prepared->edges, prepared->pixels, of_image);
    t2 = Clock::now();
    frame.table = std::make_shared<ScoreTable>(field, *levels);
    t3 = Clock::now();
  }
  prepared->times = {milliseconds(t0, t1), milliseconds(t1, t2), milliseconds(t2, t3)};
  return prepared;
}

std::shared_ptr<const FreeSpace> LocalizationMap::freeSpace() const {
  const std::lock_guard<std::mutex> lock(search_->space_mutex);
  if (!search_->space)
    search_->space = std::make_shared<FreeSpace>(
        *mesh_, FreeSpace::Options{params_.search.clearance, params_.search.enclosure});
  return search_->space;
}

std::shared_ptr<const SearchPlaces> LocalizationMap::searchPlaces() const {
  const std::lock_guard<std::mutex> lock(search_->places_mutex);
  if (!search_->places)
    search_->places = std::make_shared<SearchPlaces>(*freeSpace(), *visibility_, params_.search);
  return search_->places;
}

std::shared_ptr<const PreparedPlaces> LocalizationMap::preparedPlaces(
    const PreparedPlaces::Progress& progress) const {
  const std::lock_guard<std::mutex> lock(search_->prepared_mutex);
  if (search_->is_prepared) return search_->prepared;
  const SearchParameters& p = params_.search;
  // A camera sees an object from outside, where no place is prepared.
  const bool is_wanted = p.prepared && freeSpace()->isEnclosed();
  if (const auto axes = is_wanted ? buildingAxes(*edges_) : std::nullopt) {
    const auto make = [&] {
      return PreparedPlaces(*freeSpace(), *visibility_, p, *axes, progress);
    };
    // Both determine what a place sees.
    const double tolerances =
        visibility_->occlusionTolerance() + visibility_->occlusionToleranceOfLines();
    search_->prepared = std::make_shared<const PreparedPlaces>(
        p.store_places && !model_file_.empty()
            ? storedPreparedPlaces(model_file_,
                                   PreparedPlaces::hashOf(*mesh_, *edges_, p, tolerances), make)
            : make());
  }
  search_->is_prepared = true;
  return search_->prepared;
}

uint32_t LocalizationMap::thinningFor(const CameraView& view, const Pose& base_pose,
                                      size_t most) const {
  if (most == 0 || !view.image) return 1;
  const Pose camera_pose = base_pose * view.T_base_camera;
  const Pose camera_from_map = camera_pose.inverse();
  const CameraModel& camera = view.image->frame.camera;
  const auto set = visibility_->cached(visibility_->cellOf(camera_pose.translation()));
  size_t count = 0;  // estimated: a segment counts when its centre is in the image
  for (const VisibleSet::Segment& segment : set->segments) {
    Eigen::Vector2d pixel;
    if (camera.project(camera_from_map * set->edgeSegment(segment).centre.cast<double>(), &pixel) &&
        camera.contains(pixel))
      count += std::bitset<16>(segment.samples).count();
  }
  return static_cast<uint32_t>(std::max<size_t>(1, (count + most / 2) / most));
}

std::vector<PoseScore> LocalizationMap::evaluate(const std::vector<CameraView>& views,
                                                 const std::vector<Pose>& base_poses) const {
  std::vector<PoseScore> total(base_poses.size());
  for (const CameraView& view : views) {
    std::vector<Pose> camera_poses(base_poses);
    for (Pose& pose : camera_poses) pose = pose * view.T_base_camera;
    if (view.depth && depth_) {
      const std::vector<DepthScore> scores = depth_->evaluate(*view.depth, camera_poses);
      const auto points = static_cast<float>(view.depth->count);
      for (size_t i = 0; i < scores.size(); ++i) {
        total[i].log_likelihood += scores[i].log_likelihood;
        total[i].depth_log_likelihood += scores[i].log_likelihood;
        total[i].depth_points += points;
        total[i].depth_points_on_model += points * scores[i].agreement;
      }
    }
    if (!view.image) continue;
    LikelihoodFrame frame = view.image->frame;
    frame.thinning = view.thinning;
    const std::vector<PoseScore> scores = backend_->evaluate(frame, camera_poses);
    for (size_t i = 0; i < scores.size(); ++i) {
      total[i].log_likelihood += scores[i].log_likelihood;
      total[i].sample_weight += scores[i].sample_weight;
      total[i].line_count += scores[i].line_count;
      total[i].line_score_sum +=
          scorePerLine(params_.likelihood, scores[i].log_likelihood, scores[i].line_count) *
          scores[i].line_count;
    }
  }
  return total;
}

RefinementResult LocalizationMap::refine(const std::vector<CameraView>& views, const Pose& start,
                                         const std::optional<PoseGaussian>& prior) const {
  return refine(views, start, prior,
                {params_.refinement.iterations, params_.refinement.max_samples});
}

RefinementResult LocalizationMap::refineRoughly(const std::vector<CameraView>& views,
                                                const Pose& start,
                                                const std::optional<PoseGaussian>& prior) const {
  return refine(views, start, prior,
                {params_.refinement.start_iterations, params_.refinement.start_samples});
}

RefinementResult LocalizationMap::refine(const std::vector<CameraView>& views, const Pose& start,
                                         const std::optional<PoseGaussian>& prior,
                                         const RefinementEffort& effort) const {
  return refiner_->refine(refinementViews(views, start), start, prior, effort);
}

std::vector<RefinementView> LocalizationMap::refinementViews(const std::vector<CameraView>& views,
                                                             const Pose& pose) const {
  std::vector<RefinementView> refinement_views;
  for (const CameraView& view : views) {
    RefinementView refined;
    refined.T_base_camera = view.T_base_camera;
    refined.depth = view.depth.get();
    if (view.image) {
      refined.camera = &view.image->frame.camera;
      refined.image = &view.image->edges;
      refined.pixels = &view.image->pixels;
      refined.pixel_scale = view.image->pixel_scale;
      refined.visible =
          visibility_->cached(visibility_->cellOf((pose * view.T_base_camera).translation()));
    }
    refinement_views.push_back(std::move(refined));
  }
  return refinement_views;
}

}  // namespace edge_mcl
