#include "edge_mcl/detector/recorded_flight_masks.h"

#include <chrono>

namespace edge_mcl {

void RecordedFlightMasks::next(const cv::Mat& image, double time) {
  using Clock = std::chrono::steady_clock;
  const auto begin = Clock::now();
  tracker_.advance(image, time);
  tracking_ms_ = std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
  network_ms_ = 0;
  deliver(time);
  // A thousandth of a second: stamps are rounded.
  if (pending_ || (ran_ && time - started_ < interval_ - 1e-3)) return;
  pending_ = Result{time, detector_.detect(image)};
  network_ms_ = detector_.times().total();
  started_ = time;
  deliver(ran_ ? time : time + delay_);
  ran_ = true;
}

void RecordedFlightMasks::deliver(double now) {
  if (!pending_ || now < pending_->time + delay_ - 1e-6) return;
  tracker_.confirm(pending_->time, pending_->found);
  pending_.reset();
}

}  // namespace edge_mcl
