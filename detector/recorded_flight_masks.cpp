#include "edge_mcl/detector/recorded_flight_masks.h"

#include <chrono>
#include <stdexcept>

namespace edge_mcl {

void RecordedFlightMasks::next(const cv::Mat& image, double time) {
  using Clock = std::chrono::steady_clock;
  const auto begin = Clock::now();
  if (tracker_.advance(image, time)) {  // the tracker starts anew, as with the first image
    pending_.reset();
    ran_ = false;
  }
  tracking_ms_ = std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
  network_ms_ = 0;
  deliver(time);
  // The tolerance of 1 ms is for rounded time stamps.
  if (pending_ || (ran_ && time - started_ < interval_ - 1e-3)) return;
  tracker_.hold();
  pending_ = Result{time, detector_.detect(image)};
  network_ms_ = detector_.times().total();
  started_ = time;
  deliver(ran_ ? time : time + delay_);
  ran_ = true;
}

void RecordedFlightMasks::deliver(double now) {
  if (!pending_ || now < pending_->time + delay_ - 1e-6) return;
  if (!tracker_.confirm(pending_->time, pending_->found))
    throw std::logic_error("the tracker does not remember the image of this result");
  pending_.reset();
}

}  // namespace edge_mcl
