#include "edge_mcl/nodes/localizer/mask_matcher.h"

#include <algorithm>
#include <cmath>

#include "edge_mcl/core/base/clock_step.h"

namespace edge_mcl {

namespace {

/// At most this many images wait for their masks, so that memory is bounded: 60 MB of 640x480
/// colour images, two seconds at 30 Hz.
constexpr size_t kMostWaiting = 64;

}  // namespace

void MaskMatcher::addImage(const sensor_msgs::ImageConstPtr& image, double now) {
  if (!images_.empty() && clockStep(images_.back().image->header.stamp.toSec(),
                                    image->header.stamp.toSec()) == ClockStep::kJumpedBack) {
    dropped_ += images_.size();
    images_.clear();
    masks_.clear();
  }
  images_.push_back({image, now});
  const double stamp = image->header.stamp.toSec(), gap = stamp - newest_;
  constexpr double kSlowing = 1.2;  // a lost image must not pass for a slower camera
  if (newest_ > 0 && gap > 0) period_ = period_ > 0 ? std::min(gap, kSlowing * period_) : gap;
  newest_ = stamp;
  if (images_.size() > kMostWaiting) {
    images_.pop_front();
    ++dropped_;
  }
}

void MaskMatcher::addMask(const sensor_msgs::ImageConstPtr& mask) {
  masks_.push_back(mask);
  if (masks_.size() > kMostWaiting) masks_.pop_front();
}

std::optional<MaskMatcher::Match> MaskMatcher::complete(size_t k, double now) const {
  const Waiting& waiting = images_[k];
  const auto mask = std::find_if(masks_.begin(), masks_.end(), [&](const auto& m) {
    return m->header.stamp == waiting.image->header.stamp;
  });
  const bool has_mask = use_masks_ && mask != masks_.end();
  if (use_masks_ && !has_mask && now - waiting.since < timeout_) return std::nullopt;
  return Match{waiting.image, has_mask ? *mask : nullptr};
}

void MaskMatcher::forgetUpTo(size_t k) {
  const ros::Time stamp = images_[k].image->header.stamp;
  const auto mask = std::find_if(masks_.begin(), masks_.end(),
                                 [&](const auto& m) { return m->header.stamp == stamp; });
  if (mask != masks_.end()) masks_.erase(masks_.begin(), mask + 1);
  dropped_ += k;
  images_.erase(images_.begin(), images_.begin() + static_cast<long>(k) + 1);
}

std::optional<MaskMatcher::Match> MaskMatcher::take(double now) {
  for (size_t k = images_.size(); k-- > 0;)
    if (auto match = complete(k, now)) {
      forgetUpTo(k);
      return match;
    }
  return std::nullopt;
}

MaskMatcher::Near MaskMatcher::takeNear(const ros::Time& stamp, double window, double now) {
  Near result;
  result.newest = newest_;
  std::optional<size_t> nearest;
  for (size_t k = 0; k < images_.size(); ++k) {
    const double offset = std::abs((images_[k].image->header.stamp - stamp).toSec());
    if (offset > window) continue;
    window = offset;
    nearest = k;
  }
  if (nearest) {
    result.match = complete(*nearest, now);
    result.waits_for_mask = !result.match;
    if (result.match) forgetUpTo(*nearest);
  } else {
    // They come in the order of their stamps; a slower camera has none for every moment.
    constexpr double kEarly = 0.8;
    result.may_come =
        newest_ < stamp.toSec() && newest_ + kEarly * period_ <= stamp.toSec() + window;
  }
  return result;
}

}  // namespace edge_mcl
