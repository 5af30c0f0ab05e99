#include "edge_mcl/localization/masks/mask_lifter.h"

#include <cmath>
#include <utility>

#include "edge_mcl/core/image/pixel_scale.h"

namespace edge_mcl {

namespace {

constexpr int kImages = 3;  // images in a row that must show a line
// Least length of a line under the mask, pixels, and least share of it with an image edge.
constexpr double kLeastLength = 24, kLeastShare = 0.8;

bool isSeen(const LineUnderMask& line) {
  return line.length >= kLeastLength && line.shown >= kLeastShare * line.length;
}

/// The model lines under a mask. @param sigmas largest distance of an image edge from its line, in
/// units of likelihood.sigma.
std::vector<LineUnderMask> linesUnder(const cv::Mat& mask, const EdgePixels& edges,
                                      const LocalizationMap& map, const CameraModel& camera,
                                      const Pose& T_map_camera, double sigmas) {
  const Parameters& p = map.params();
  const double sigma = pixelScale(p.image, mask.size()) * p.likelihood.sigma;
  const EdgeReach reach = {sigmas * sigma,
                           std::cos(p.image.orientation_tolerance_deg * M_PI / 180)};
  const Visibility& visibility = map.visibility();
  return linesUnderMask(mask, edges,
                        *visibility.cached(visibility.cellOf(T_map_camera.translation())), camera,
                        T_map_camera, map.edges().sample_step, reach);
}

}  // namespace

cv::Mat MaskLifter::lift(size_t view, const LocalizationMap& map, const CameraModel& camera,
                         const cv::Mat& image, const cv::Mat& mask, const Pose& T_map_camera) {
  View& memory = views_[view];
  memory.last.reset();
  if (cv::countNonZero(mask) == 0) {
    memory.confirmed.clear();
    return mask;
  }
  const Parameters& p = map.params();
  const double scale = pixelScale(p.image, image.size());
  const ImageParameters of_image = scaledBy(scale, p.image);
  memory.last =
      Seen{camera, mask.clone(), EdgePixels(findEdges(image, cv::Mat(), of_image, "image"))};
  if (memory.confirmed.empty()) return mask;
  // The mask is dilated again later. The score of a sample depends on distances up to about four
  // sigma, so the image must be free of the mask that far from the line.
  const double band = 4 * scale * p.likelihood.sigma + of_image.mask_dilation;
  cv::Mat lifted = mask;
  for (const LineUnderMask& line :
       linesUnder(mask, memory.last->edges, map, camera, T_map_camera, 2)) {
    const auto found = memory.confirmed.find(line.line);
    if (found == memory.confirmed.end() || found->second < kImages || !isSeen(line)) continue;
    if (lifted.data == mask.data) lifted = mask.clone();
    clearAlong(line, band, &lifted);
  }
  return lifted;
}

void MaskLifter::learn(const LocalizationMap& map, const Pose& base_pose,
                       const std::vector<Pose>& T_base_camera) {
  for (auto& [number, view] : views_) {
    if (!view.last || number >= T_base_camera.size()) {
      view.confirmed.clear();
      continue;
    }
    const Seen seen = *std::exchange(view.last, std::nullopt);
    const Pose T_map_camera = base_pose * T_base_camera[number];
    std::map<uint32_t, int> confirmed;
    for (const LineUnderMask& line :
         linesUnder(seen.mask, seen.edges, map, seen.camera, T_map_camera, 1)) {
      const auto before = view.confirmed.find(line.line);
      if (isSeen(line))
        confirmed[line.line] = (before == view.confirmed.end() ? 0 : before->second) + 1;
    }
    view.confirmed = std::move(confirmed);
  }
}

void MaskLifter::forget() { views_.clear(); }

}  // namespace edge_mcl
