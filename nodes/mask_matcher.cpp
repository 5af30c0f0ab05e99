#include "edge_mcl/nodes/mask_matcher.h"

#include <algorithm>

namespace edge_mcl {

namespace {

/// More than this many images do not wait, whatever the timeout: memory is bounded.
constexpr size_t kMostWaiting = 64;

}  // namespace

void MaskMatcher::addImage(const sensor_msgs::ImageConstPtr& image, double now) {
  // The clock jumped back: what waits belongs to another time.
  constexpr double kJump = 1;  // s
  if (!images_.empty() &&
      (images_.back().image->header.stamp - image->header.stamp).toSec() > kJump) {
    dropped_ += images_.size();
    images_.clear();
    masks_.clear();
  }
  images_.push_back({image, now});
  if (images_.size() > kMostWaiting) {
    images_.pop_front();
    ++dropped_;
  }
}

void MaskMatcher::addMask(const sensor_msgs::ImageConstPtr& mask) {
  masks_.push_back(mask);
  last_mask_ = mask;
  if (masks_.size() > kMostWaiting) masks_.pop_front();
}

std::optional<MaskMatcher::Match> MaskMatcher::take(double now) {
  for (size_t k = images_.size(); k-- > 0;) {
    const Waiting& candidate = images_[k];
    const auto mask = std::find_if(masks_.begin(), masks_.end(), [&](const auto& m) {
      return m->header.stamp == candidate.image->header.stamp;
    });
    const bool has_mask = use_masks_ && mask != masks_.end();
    if (use_masks_ && !has_mask && now - candidate.since < timeout_) continue;
    const Match match{candidate.image, has_mask ? *mask : nullptr};
    if (has_mask) masks_.erase(masks_.begin(), mask + 1);
    dropped_ += k;
    images_.erase(images_.begin(), images_.begin() + static_cast<long>(k) + 1);
    return match;
  }
  return std::nullopt;
}

}  // namespace edge_mcl
