/// Keeps found objects masked between two runs of the network, and knows them again.
///
/// The paper: once found, an object is quickly identified in all further images, in real time.
#pragma once

#include <deque>
#include <opencv2/core.hpp>
#include <vector>

#include "edge_mcl/detector/detections.h"
#include "edge_mcl/detector/detector_parameters.h"

namespace edge_mcl {

/// Every image is handed to advance(); hold() says that the network begins with it, and whenever it
/// is done its result goes to confirm(), however late. Objects are carried from image to image by
/// the optical flow of corners on them (Lucas-Kanade, checked backwards), or, where too few can be
/// followed, by that of the background: what stands still moves with it. Not thread-safe.
class ObjectTracker {
 public:
  explicit ObjectTracker(const DetectorParameters& parameters) : parameters_(parameters) {}

  /// @param image CV_8UC3 or CV_8U. @param time s.
  /// @return true when nothing is known before this image: the first one, one of another size, or
  /// one more than a second before the last (a bag in a loop).
  /// @throws InputError for an image of another type, or one that is not later than the last by
  /// less than that: it is not taken, all else stays.
  bool advance(const cv::Mat& image, double time);

  /// The network begins with the newest image: until confirm() that one is remembered, and of those
  /// that follow kHistory at most, spread evenly, so that carrying its result to now takes no
  /// longer.
  void hold();

  /// What the network found in the image of a time that was handed in. Ignored when that image is
  /// not remembered: without hold() it is one of the newest kHistory.
  /// @return false when it was ignored.
  bool confirm(double time, const Detections& found);

  /// Objects as they are in the newest image, masks of its size; score is the confidence.
  Detections objects() const;
  /// All of them, grown by `dilation` and by `dilation_growth` for their age.
  cv::Mat mask() const;
  void clear();

  /// Images that are remembered.
  static constexpr size_t kHistory = 32;

 private:
  struct Frame {
    double time;
    cv::Mat grey, color;  // small
  };
  struct Track {
    int id = 0, class_id = 0;
    float score = 0;     // when last confirmed
    double seen_at = 0;  // when the network last saw it
    int misses = 0;
    cv::Mat mask;                         // small, when last confirmed
    cv::Matx23d moved{1, 0, 0, 0, 1, 0};  // since then, small pixels
    std::vector<float> colors;            // histogram
    double trust = 1;  // share of its corners that could be followed, multiplied up
  };
  struct Remembered {
    int id, class_id;
    double lost_at;
    std::vector<float> colors;
  };
  void forgetFrames();
  Frame smallFrame(const cv::Mat& image, double time) const;
  void carry(const Frame& from, const Frame& to, std::vector<Track>* tracks) const;
  cv::Mat maskNow(const Track& track) const;
  double confidence(const Track& track) const;
  void forget(const Track& track);
  int identify(const Track& track);

  DetectorParameters parameters_;
  cv::Size size_, small_size_;
  std::deque<Frame> frames_;
  bool held_ = false;  // the first frame is at the network
  std::vector<Track> tracks_;
  std::vector<Remembered> remembered_;
  int next_id_ = 1;
};

}  // namespace edge_mcl
