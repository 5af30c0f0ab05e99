/// Masks for a recording, as a network of limited speed would give them in flight.
#pragma once

#include <optional>

#include "edge_mcl/detector/mask_detector.h"
#include "edge_mcl/detector/object_tracker.h"

namespace edge_mcl {

/// Runs the network on the images that its rate allows, hands in each result when its delay is
/// over, and tracks in between. By the images' times alone: the same on every machine.
class RecordedFlightMasks {
 public:
  /// @param rate runs of the network per second; 0: on every image.
  /// @param delay s after which a result is there; the first is waited for, as nothing is known
  /// before, and likewise after an image of another size. A new run begins when the last one's
  /// result is there.
  RecordedFlightMasks(MaskDetector* detector, const DetectorParameters& parameters, double rate,
                      double delay)
      : interval_(rate > 0 ? 1 / rate : 0),
        delay_(delay),
        detector_(*detector),
        tracker_(parameters) {}

  /// The next image; times must increase.
  void next(const cv::Mat& image, double time);

  const ObjectTracker& tracker() const { return tracker_; }
  double trackingMs() const { return tracking_ms_; }  ///< of the last image
  double networkMs() const { return network_ms_; }    ///< likewise; 0: it did not run

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
