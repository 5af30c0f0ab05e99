// How LiveLocalizer prepares images, masks and depth images for the filter.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <opencv2/core.hpp>
#include <utility>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/localization/tracking/live_localizer.h"

namespace edge_mcl {

namespace {

using Clock = std::chrono::steady_clock;

double millisecondsSince(Clock::time_point begin) {
  return std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
}

/// @param mask empty: none
double maskedShare(const cv::Mat& mask) {
  if (mask.empty() || mask.type() != CV_8UC1) return 0;  // the preparation refuses other types
  return cv::countNonZero(mask) / static_cast<double>(mask.total());
}

}  // namespace

cv::Mat LiveLocalizer::maskOf(size_t number, const LiveInput::CameraImage& view) {
  // Only while the pose is trusted: at a wrong pose other edges under the mask may fit by chance.
  const bool fits = view.mask.type() == CV_8UC1 && view.mask.size() == view.image.size() &&
                    view.image.cols == view.camera.width && view.image.rows == view.camera.height;
  if (!tracking_.lift_mask || state() != LocalizerState::kTracking || view.mask.empty() || !fits)
    return view.mask;
  try {
    return mask_lifter_.lift(number, *map_, view.camera, view.image, view.mask,
                             filter_.estimate().mean * view.T_base_camera);
  } catch (const InputError&) {
    return view.mask;  // the preparation of the image reports this fault
  }
}

void LiveLocalizer::learnUnderMasks(const LiveInput& input, bool used) {
  // Images are counted in a row. An image that was not used, or did not confirm the pose, ends the
  // row.
  if (!used || state() != LocalizerState::kTracking) return mask_lifter_.forget();
  std::vector<Pose> T_base_camera;
  for (const LiveInput::CameraImage& view : input.images)
    T_base_camera.push_back(view.T_base_camera);
  mask_lifter_.learn(*map_, filter_.estimate().mean, T_base_camera);
}

void LiveLocalizer::checkCalibration(const LiveInput& input, LiveResult* result) {
  if (!result->updated || state() != LocalizerState::kTracking || !result->problem.empty()) return;
  for (const size_t number : result->image_numbers) {
    const LiveInput::CameraImage& view = input.images[number];
    const AskedImage asked{*map_, view.image, view.mask, view.T_base_camera,
                           filter_.estimate().mean};
    const std::string fault =
        calibration_checks_.look(asked, view.camera, result->report.focal_error, input.time);
    if (fault.empty()) continue;
    result->problem = view.origin + ": " + fault;
    result->is_told_once = true;
    return filter_.setFocalError(calibration_checks_.focalError());
  }
}

std::vector<DepthMasker::Foreign> LiveLocalizer::foreignParts(const LiveInput& input,
                                                              LiveResult* result,
                                                              std::string* problem) {
  // At a wrong pose the building itself is in front of the model, and more of it behind. Where
  // nearly nothing is behind the model, the pose is likely, even when edges cannot tell. The limit
  // lies between right poses (0.95 and more) and wrong ones (at most 0.9 in 100 of 100).
  constexpr double kLikely = 0.9, kAgreement = 0.9;
  // A likely pose with less agreement: depth and model do not belong together.
  constexpr double kLeastAgreement = 0.7;
  std::vector<DepthMasker::Foreign> foreign;
  foreign_.clear();
  surface_agreement_.begin(input.time, filter_.estimate());
  if (!tracking_.mask_by_depth || !isInitialized()) {
    depth_masker_.forget();
    return foreign;
  }
  const bool is_likely = state() == LocalizerState::kTracking && probability_.value() >= kLikely;
  const bool has_masks = std::any_of(input.images.begin(), input.images.end(),
                                     [](const auto& view) { return !view.mask.empty(); });
  for (size_t number = 0; number < input.depths.size(); ++number) try {
      const LiveInput::Depth& depth = input.depths[number];
      DepthMasker::Foreign found =
          DepthMasker::find(*map_, depth.image, filter_.estimate(), depth.T_base_camera, has_masks);
      const double agreement = found.points.agreement;
      surface_agreement_.add(found.points);
      if (searching_) continue;  // the search sees the whole image
      result->foreign_agreement = std::max(result->foreign_agreement, agreement);
      result->depth_agrees = result->foreign_agreement >= kLeastAgreement;
      if (agreement < (is_likely ? kLeastAgreement : kAgreement)) continue;
      foreign_.emplace_back(number, found.points);
      foreign.push_back(std::move(found));
    } catch (const InputError& e) {
      *problem = e.what();
    }
  if (foreign.empty()) depth_masker_.forget();  // masks begin anew, and small
  return foreign;
}

void LiveLocalizer::followObjects(const LiveInput& input, LiveResult* result) {
  if (result->updated && state() == LocalizerState::kTracking && !foreign_.empty()) {
    const Clock::time_point begin = Clock::now();
    const Pose& T_map_base = filter_.estimate().mean;
    std::vector<ForeignDepth> depths;
    for (const auto& [number, points] : foreign_)
      depths.push_back(
          {input.depths[number].image, points, T_map_base * input.depths[number].T_base_camera});
    std::vector<ForeignColour> colours;
    for (const LiveInput::CameraImage& view : input.images)
      colours.push_back({view.image, view.camera, T_map_base * view.T_base_camera});
    const RayScene* scene = map_->visibility().scene();
    objects_.update(input.time, depths, colours, scene, map_->params().depth);
    result->objects_ms = millisecondsSince(begin);
  }
}

cv::Mat LiveLocalizer::withForeign(size_t number, const LiveInput::CameraImage& view,
                                   const std::vector<DepthMasker::Foreign>& foreign,
                                   LiveResult* result) {
  cv::Mat lifted = maskOf(number, view);
  if (foreign.empty()) return lifted;
  const Clock::time_point begin = Clock::now();
  cv::Mat mask = depth_masker_.add(number, foreign, view.camera, view.T_base_camera,
                                   tracking_.max_masked_share, lifted);
  result->foreign_ms += millisecondsSince(begin);
  const double change = maskedShare(mask) - maskedShare(lifted);
  if (std::abs(change) > std::abs(result->foreign_share)) result->foreign_share = change;
  return mask;
}

void LiveLocalizer::prepareImages(const LiveInput& input, LiveResult* result,
                                  std::vector<CameraView>* views, std::string* problem) {
  const TrackingParameters& p = tracking_;
  const Clock::time_point begin = Clock::now();
  const std::vector<DepthMasker::Foreign> foreign = foreignParts(input, result, problem);
  result->foreign_ms = millisecondsSince(begin);
  for (size_t number = 0; number < input.images.size(); ++number) {
    const LiveInput::CameraImage& view = input.images[number];
    if (calibration_checks_.note(view.camera, input.time))
      filter_.setFocalError(calibration_checks_.focalError());
    const cv::Mat mask = withForeign(number, view, foreign, result);
    const double share = maskedShare(mask);
    result->masked_share = std::max(result->masked_share, share);
    if (share > p.max_masked_share) {
      *problem = view.origin + ": the mask leaves too little of the image";
      continue;
    }
    std::shared_ptr<const PreparedImage> image;
    try {
      image = map_->prepare(view.camera, view.image, mask, view.origin);
    } catch (const Error& e) {
      *problem = e.what();
      continue;
    }
    result->image_times.edges += image->times.edges;
    result->image_times.field += image->times.field;
    result->image_times.table += image->times.table;
    if (static_cast<double>(image->pixels.list().size()) < image->pixel_scale * p.min_edge_pixels) {
      *problem = view.origin + ": hardly any edges in the image (dark or covered?)";
      continue;
    }
    result->images.push_back(image);
    result->image_numbers.push_back(number);
    views->push_back({image, view.T_base_camera, 1, nullptr});
  }
}

std::vector<CameraView> LiveLocalizer::prepareDepths(const LiveInput& input,
                                                     std::string* problem) const {
  constexpr size_t kFewestPoints = 50;
  std::vector<CameraView> views;
  for (const LiveInput::Depth& depth : input.depths) {
    try {
      std::shared_ptr<const DepthPoints> points = map_->prepareDepth(depth.image);
      if (points->count < kFewestPoints)
        *problem = depth.image.origin + ": hardly any depth in range (covered?)";
      else
        views.push_back({nullptr, depth.T_base_camera, 1, std::move(points), depth.sensor});
    } catch (const Error& e) {
      *problem = e.what();
    }
  }
  return views;
}

std::vector<CameraView> LiveLocalizer::prepare(const LiveInput& input, LiveResult* result,
                                               std::string* problem) {
  std::vector<CameraView> views;
  if (map_->usesImages()) prepareImages(input, result, &views, problem);
  if (map_->usesDepth())
    for (CameraView& view : prepareDepths(input, problem)) views.push_back(std::move(view));
  if (views.empty() && problem->empty()) *problem = "no image";
  return views;
}

}  // namespace edge_mcl
