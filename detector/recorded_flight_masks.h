/// Makes masks for a recording as a network of limited speed gives them in flight.
#pragma once

#include <optional>

#include "edge_mcl/detector/mask_detector.h"
#include "edge_mcl/detector/object_tracker.h"

namespace edge_mcl {

/// Runs the network at a given rate, uses each result after a given delay, and tracks objects in
/// between. Only the time stamps of the images count, so the result is the same on every machine.
class RecordedFlightMasks {
 public:
  /// @param rate runs of the network per second; 0: on every image. A new run begins only after the
  /// result of the last one was used.
  /// @param delay s from an image to the use of its result. The first result is used at once,
  /// because no object is known before. This also holds when the tracker starts anew, see
  /// ObjectTracker::advance().
  RecordedFlightMasks(MaskDetector* detector, const DetectorParameters& parameters, double rate,
                      double delay)
      : interval_(rate > 0 ? 1 / rate : 0),
        delay_(delay),
        detector_(*detector),
        tracker_(parameters) {}

  /// Uses the next image. @param time s; must increase.
  void next(const cv::Mat& image, double time);

  const ObjectTracker& tracker() const { return tracker_; }
  double trackingMs() const { return tracking_ms_; }  ///< time of tracking in the last image
  double networkMs() const { return network_ms_; }    ///< time of the network; 0: it did not run

 private:
  struct Result {
    double time;
    Detections found;
  };
  void deliver(double now);

  double interval_, delay_, started_ = 0, tracking_ms_ = 0, network_ms_ = 0;
  bool ran_ = false;
  MaskDetector& detector_;
  ObjectTracker tracker_;
  std::optional<Result> pending_;
};

}  // namespace edge_mcl
