#include "edge_mcl/detector/object_tracker.h"

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>
#include <tuple>

#include "edge_mcl/core/base/clock_step.h"
#include "edge_mcl/core/base/error.h"

namespace edge_mcl {

namespace {

// The values below were set by looking at tracks in the simulated flights of bench/masks. No single
// one has been measured alone.

/// Width of the image in which objects are tracked, px. Masks need no finer detail.
constexpr int kSmallWidth = 320;
/// Overlap (intersection over union) from which two masks are one object. Outlines of one object
/// in two runs of the network differ by about that much.
constexpr double kSameObject = 0.3;
/// Correlation of colour histograms from which an object that ended is known again.
constexpr double kSameColors = 0.75;
/// Fewer corners than this do not tell how an object moved: a similarity transform takes two, and
/// outliers must be outvoted.
constexpr size_t kFewPoints = 5;
/// An object that is covered by another one to more than this share is a part of it.
constexpr double kSwallowed = 0.7;

/// Share of the confidence that an object keeps per image without the network, at kPace images per
/// second. It depends on how the motion of the object is known: from its own corners (from 0.9
/// to 1, by the share of corners that move alike), from the motion of the whole image, or not.
constexpr double kKeptByCorners = 0.9, kKeptByMoreCorners = 0.1;
constexpr double kKeptByWorld = 0.93, kKeptBlindly = 0.8;
constexpr double kPace = 15.0;

cv::Matx23d chained(const cv::Matx23d& then, const cv::Matx23d& first) {
  cv::Matx23d m;
  for (int r = 0; r < 2; ++r) {
    for (int c = 0; c < 3; ++c) m(r, c) = then(r, 0) * first(0, c) + then(r, 1) * first(1, c);
    m(r, 2) += then(r, 2);
  }
  return m;
}

/// Hue and saturation of what a mask covers; 16 by 8 cells, sums to one.
std::vector<float> colorsUnder(const cv::Mat& color, const cv::Mat& mask) {
  cv::Mat hsv;
  cv::cvtColor(color, hsv, cv::COLOR_BGR2HSV);
  std::vector<float> histogram(16 * 8 + 8, 0);
  double total = 0;
  for (int y = 0; y < mask.rows; ++y)
    for (int x = 0; x < mask.cols; ++x) {
      if (!mask.at<uint8_t>(y, x)) continue;
      const auto& p = hsv.at<cv::Vec3b>(y, x);
      // Hue says nothing about grey things: those are told apart by their brightness.
      const int cell = p[1] < 40 ? 128 + p[2] / 32 : std::min(15, p[0] * 16 / 180) * 8 + p[1] / 32;
      histogram[static_cast<size_t>(cell)] += 1;
      total += 1;
    }
  if (total > 0)
    for (float& h : histogram) h = static_cast<float>(h / total);
  return histogram;
}

/// Bhattacharyya coefficient: 1 for equal histograms.
double similarity(const std::vector<float>& a, const std::vector<float>& b) {
  double sum = 0;
  for (size_t i = 0; i < std::min(a.size(), b.size()); ++i)
    sum += std::sqrt(static_cast<double>(a[i]) * b[i]);
  return sum;
}

/// Corners followed from one image to the next and back again.
struct Flow {
  std::vector<cv::Point2f> from, to;
};

/// Shift, turn and scale that most of the corners agree on. @return false when too few do.
bool commonMotion(const Flow& flow, cv::Matx23d* motion, double* share) {
  if (flow.from.size() < kFewPoints) return false;
  cv::Mat inliers;
  const cv::Mat found =
      cv::estimateAffinePartial2D(flow.from, flow.to, inliers, cv::RANSAC, 2.0, 500, 0.99, 5);
  if (found.empty()) return false;
  const int count = cv::countNonZero(inliers);
  const double scale = std::hypot(found.at<double>(0, 0), found.at<double>(1, 0));
  if (count < static_cast<int>(kFewPoints) || !(scale > 0.7 && scale < 1.4)) return false;
  *motion = cv::Matx23d(found.ptr<double>());
  *share = static_cast<double>(count) / static_cast<double>(flow.from.size());
  return true;
}

}  // namespace

ObjectTracker::Frame ObjectTracker::smallFrame(const cv::Mat& image, double time) const {
  Frame frame;
  frame.time = time;
  cv::resize(image, frame.color, small_size_, 0, 0,
             small_size_ == image.size() ? cv::INTER_NEAREST : cv::INTER_AREA);
  if (frame.color.channels() == 1) {
    frame.grey = frame.color;
    cv::cvtColor(frame.grey, frame.color, cv::COLOR_GRAY2BGR);
  } else {
    cv::cvtColor(frame.color, frame.grey, cv::COLOR_BGR2GRAY);
  }
  return frame;
}

bool ObjectTracker::advance(const cv::Mat& image, double time) {
  if (image.empty() || (image.type() != CV_8UC3 && image.type() != CV_8UC1))
    throw InputError("object tracker: an image of 8 bits in colour or grey is needed");
  const bool first = frames_.empty();
  if (!first && clockStep(frames_.back().time, time) == ClockStep::kLate)
    throw InputError("object tracker: an image of " + std::to_string(time) +
                     " s is not later than the one before, of " +
                     std::to_string(frames_.back().time) + " s");
  const bool anew = first || image.size() != size_ || time < frames_.back().time;
  if (anew) {
    clear();
    size_ = image.size();
    small_size_ = size_;
    if (size_.width > kSmallWidth)
      small_size_ = {kSmallWidth, std::max(1, cvRound(static_cast<double>(size_.height) *
                                                      kSmallWidth / size_.width))};
  }
  Frame frame = smallFrame(image, time);
  if (!frames_.empty()) carry(frames_.back(), frame, &tracks_);
  frames_.push_back(std::move(frame));
  forgetFrames();
  for (const Track& track : tracks_)
    if (confidence(track) < parameters_.min_confidence) forget(track);
  tracks_.erase(
      std::remove_if(tracks_.begin(), tracks_.end(),
                     [&](const Track& t) { return confidence(t) < parameters_.min_confidence; }),
      tracks_.end());
  return anew;
}

void ObjectTracker::hold() {
  if (frames_.empty()) return;
  frames_.erase(frames_.begin(), frames_.end() - 1);
  held_ = true;
}

void ObjectTracker::forgetFrames() {
  if (frames_.size() <= kHistory) return;
  if (!held_) {
    frames_.pop_front();
    return;
  }
  // The one whose neighbours are nearest to each other: gaps stay as small as they can be.
  size_t least = 1;
  const auto gapWithout = [&](size_t i) { return frames_[i + 1].time - frames_[i - 1].time; };
  for (size_t i = 2; i + 1 < frames_.size(); ++i)
    if (gapWithout(i) < gapWithout(least)) least = i;
  frames_.erase(frames_.begin() + static_cast<std::ptrdiff_t>(least));
}

void ObjectTracker::carry(const Frame& from, const Frame& to, std::vector<Track>* tracks) const {
  if (tracks->empty()) return;
  // Corners of all objects and of the background are followed in one go.
  cv::Mat background(small_size_, CV_8U, cv::Scalar(255));
  std::vector<cv::Point2f> points;
  std::vector<size_t> owner;
  const auto addCorners = [&](const cv::Mat& where, int count, size_t whose) {
    std::vector<cv::Point2f> corners;
    cv::goodFeaturesToTrack(from.grey, corners, count, 0.01, 4, where, 3);
    points.insert(points.end(), corners.begin(), corners.end());
    owner.insert(owner.end(), corners.size(), whose);
  };
  for (size_t k = 0; k < tracks->size(); ++k) {
    cv::Mat grown = maskNow((*tracks)[k]), inner;
    // A corner on the outline is half of the background and may move with that: the outline is used
    // only where there is little to follow within.
    cv::erode(grown, inner, cv::Mat::ones(7, 7, CV_8U), {-1, -1}, 1, cv::BORDER_CONSTANT);
    const size_t before = points.size();
    addCorners(inner, parameters_.points, k);
    dilateMask(2, &grown);
    if (points.size() - before < 2 * kFewPoints) addCorners(grown, parameters_.points, k);
    background.setTo(0, grown);
  }
  addCorners(background, 2 * parameters_.points, tracks->size());
  std::vector<Flow> flows(tracks->size() + 1);
  if (!points.empty()) {
    std::vector<cv::Point2f> there, back;
    std::vector<uint8_t> found, found_back;
    std::vector<float> error;
    const cv::Size window(15, 15);
    cv::calcOpticalFlowPyrLK(from.grey, to.grey, points, there, found, error, window, 3);
    cv::calcOpticalFlowPyrLK(to.grey, from.grey, there, back, found_back, error, window, 3);
    for (size_t i = 0; i < points.size(); ++i) {
      if (!found[i] || !found_back[i] || cv::norm(back[i] - points[i]) > 0.7) continue;
      flows[owner[i]].from.push_back(points[i]);
      flows[owner[i]].to.push_back(there[i]);
    }
  }
  cv::Matx23d world(1, 0, 0, 0, 1, 0);
  double share = 1;
  const bool world_known = commonMotion(flows.back(), &world, &share);
  const double paces = kPace * std::max(0.0, to.time - from.time);
  for (size_t k = 0; k < tracks->size(); ++k) {
    Track& track = (*tracks)[k];
    cv::Matx23d motion = world;
    double kept = world_known ? kKeptByWorld : kKeptBlindly;
    if (commonMotion(flows[k], &motion, &share)) kept = kKeptByCorners + kKeptByMoreCorners * share;
    track.trust *= std::pow(kept, paces);
    track.moved = chained(motion, track.moved);
  }
}

cv::Mat ObjectTracker::maskNow(const Track& track) const {
  cv::Mat moved;
  cv::warpAffine(track.mask, moved, track.moved, small_size_, cv::INTER_NEAREST,
                 cv::BORDER_CONSTANT, cv::Scalar(0));
  return moved;
}

double ObjectTracker::confidence(const Track& track) const {
  const double age = std::max(0.0, frames_.back().time - track.seen_at);
  return track.score * track.trust * std::pow(0.5, age / parameters_.half_life + track.misses);
}

void ObjectTracker::forget(const Track& track) {
  remembered_.push_back({track.id, track.class_id, frames_.back().time, track.colors});
}

int ObjectTracker::identify(const Track& track) {
  remembered_.erase(std::remove_if(remembered_.begin(), remembered_.end(),
                                   [&](const Remembered& r) {
                                     return frames_.back().time - r.lost_at > parameters_.memory;
                                   }),
                    remembered_.end());
  auto best = remembered_.end();
  double highest = kSameColors;
  for (auto r = remembered_.begin(); r != remembered_.end(); ++r) {
    const double s = similarity(r->colors, track.colors);
    if (r->class_id == track.class_id && s > highest) {
      highest = s;
      best = r;
    }
  }
  if (best == remembered_.end()) return next_id_++;
  const int id = best->id;
  remembered_.erase(best);
  return id;
}

bool ObjectTracker::confirm(double time, const Detections& found) {
  const auto seen =
      std::find_if(frames_.begin(), frames_.end(), [&](const Frame& f) { return f.time == time; });
  if (seen == frames_.end()) return false;
  held_ = false;
  std::vector<Track> fresh;
  for (const Detection& d : found) {
    if (d.mask.size() != size_) throw InputError("object tracker: a mask of another size");
    Track track;
    track.class_id = d.class_id;
    track.score = d.score;
    track.seen_at = time;
    cv::resize(d.mask, track.mask, small_size_, 0, 0, cv::INTER_NEAREST);
    if (cv::countNonZero(track.mask) == 0) continue;
    track.colors = colorsUnder(seen->color, track.mask);
    fresh.push_back(std::move(track));
  }
  // The network took its time: what it found is carried over to the newest image.
  for (auto from = seen; std::next(from) != frames_.end(); ++from)
    carry(*from, *std::next(from), &fresh);

  std::vector<cv::Mat> old_masks, new_masks;
  for (const Track& t : tracks_) old_masks.push_back(maskNow(t));
  for (const Track& t : fresh) new_masks.push_back(maskNow(t));
  std::vector<bool> met(tracks_.size(), false);
  struct Pair {
    double overlap;
    size_t fresh, old;
  };
  std::vector<Pair> pairs;
  for (size_t i = 0; i < fresh.size(); ++i) {
    if (cv::countNonZero(new_masks[i]) == 0) continue;  // what is out of sight is like nothing
    for (size_t k = 0; k < tracks_.size(); ++k) {
      const double overlap = maskOverlap(new_masks[i], old_masks[k]);
      if (overlap > kSameObject) pairs.push_back({overlap, i, k});
    }
  }
  std::sort(pairs.begin(), pairs.end(), [](const Pair& a, const Pair& b) {
    return std::tie(b.overlap, a.fresh, a.old) < std::tie(a.overlap, b.fresh, b.old);
  });
  for (const Pair& p : pairs) {
    if (met[p.old] || fresh[p.fresh].id != 0) continue;
    met[p.old] = true;
    fresh[p.fresh].id = tracks_[p.old].id;
  }
  for (Track& track : fresh)
    if (track.id == 0) track.id = identify(track);
  for (size_t k = 0; k < tracks_.size(); ++k) {
    if (met[k]) continue;
    // The network may now see two objects as one.
    const bool swallowed = std::any_of(new_masks.begin(), new_masks.end(), [&](const cv::Mat& m) {
      return cv::countNonZero(m & old_masks[k]) > kSwallowed * cv::countNonZero(old_masks[k]);
    });
    Track track = tracks_[k];
    if (swallowed || ++track.misses >= parameters_.max_misses)
      forget(track);
    else
      fresh.push_back(std::move(track));
  }
  tracks_ = std::move(fresh);
  return true;
}

Detections ObjectTracker::objects() const {
  Detections all;
  for (const Track& track : tracks_) {
    Detection d;
    cv::resize(maskNow(track), d.mask, size_, 0, 0, cv::INTER_NEAREST);
    const cv::Rect box = cv::boundingRect(d.mask);
    if (box.area() == 0) continue;  // out of sight for now
    d.class_id = track.class_id;
    d.score = static_cast<float>(confidence(track));
    d.box = box;
    d.track_id = track.id;
    d.age = std::max(0.0, frames_.back().time - track.seen_at);
    all.push_back(std::move(d));
  }
  return all;
}

cv::Mat ObjectTracker::mask() const {
  if (frames_.empty()) return {};
  cv::Mat all = cv::Mat::zeros(small_size_, CV_8U);
  const double scale = static_cast<double>(small_size_.width) / kSmallWidth;
  const double diagonal = std::hypot(small_size_.width, small_size_.height);
  for (const Track& track : tracks_) {
    cv::Mat mask = maskNow(track);
    const double age = std::max(0.0, frames_.back().time - track.seen_at);
    const double growth = parameters_.dilation + parameters_.dilation_growth * age;
    dilateMask(cvRound(std::min(diagonal, scale * growth)), &mask);
    all |= mask;
  }
  cv::Mat full;
  cv::resize(all, full, size_, 0, 0, cv::INTER_NEAREST);
  return full;
}

void ObjectTracker::clear() {
  frames_.clear();
  tracks_.clear();
  remembered_.clear();
  held_ = false;
}

}  // namespace edge_mcl
