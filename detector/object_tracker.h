/// Keeps detected objects masked between two runs of the network, and recognizes them later.
///
/// The paper says that an object, once found, is quickly identified in all further images in real
/// time.
#pragma once

#include <deque>
#include <opencv2/core.hpp>
#include <vector>

#include "edge_mcl/detector/detections.h"
#include "edge_mcl/detector/detector_parameters.h"

namespace edge_mcl {

/// Tracks detected objects from image to image. Call advance() with every image. Call hold() when
/// the network starts with the newest image, and confirm() when its result is there, however late.
/// Objects are moved by the optical flow of corners on them (Lucas-Kanade, checked backwards). With
/// too few corners an object is moved by the flow of the background, because an object at rest
/// moves with the background. Not thread-safe.
class ObjectTracker {
 public:
  explicit ObjectTracker(const DetectorParameters& parameters) : parameters_(parameters) {}

  /// Moves all objects to the next image. @param image CV_8UC3 or CV_8U. @param time s.
  /// @return true when the tracker starts anew with this image: it is the first image, has another
  /// size, or is more than 1 s older than the last one (a bag in a loop).
  /// @throws InputError for an image of another type, or a time that is not later than the last one
  /// and at most 1 s earlier. Such an image is not used, and the state stays.
  bool advance(const cv::Mat& image, double time);

  /// Says that the network starts with the newest image. This image is remembered until confirm().
  /// Of it and the images that follow, kHistory are remembered at most, spread evenly in time. So
  /// the time to move the result of the network to the newest image is limited.
  void hold();

  /// Takes the result of the network for the image of this time (s). Without hold() only the newest
  /// kHistory images are remembered. @return false when the image is not remembered; the result is
  /// then ignored. @throws InputError for a mask of another size.
  bool confirm(double time, const Detections& found);

  /// Objects in the newest image. Their masks have the image's size, their score is the confidence.
  Detections objects() const;
  /// Joined mask of all objects in the newest image, CV_8U. Every object is grown by the parameters
  /// `dilation` and, for its age, `dilation_growth`.
  cv::Mat mask() const;
  /// Forgets all images and objects.
  void clear();

  /// Largest number of remembered images.
  static constexpr size_t kHistory = 32;

 private:
  struct Frame {
    double time;
    cv::Mat grey, color;  // reduced in size
  };
  struct Track {
    int id = 0, class_id = 0;
    float score = 0;                      // score of the last confirmation
    double seen_at = 0;                   // time at which the network last saw it, s
    int misses = 0;                       // runs of the network in a row that did not find it
    cv::Mat mask;                         // at the last confirmation, reduced in size
    cv::Matx23d moved{1, 0, 0, 0, 1, 0};  // motion since then, pixels of the reduced image
    std::vector<float> colors;            // histogram
    double trust = 1;                     // product of the trust in the motion from image to image
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
  bool held_ = false;  // the network works on the first frame
  std::vector<Track> tracks_;
  std::vector<Remembered> remembered_;
  int next_id_ = 1;
};

}  // namespace edge_mcl
