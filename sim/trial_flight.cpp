#include "edge_mcl/sim/trial_flight.h"

#include <cmath>

#include "edge_mcl/core/base/error.h"

namespace edge_mcl {

TrialKind trialKind(const std::string& name) {
  if (name == "global") return TrialKind::kGlobal;
  if (name == "offset") return TrialKind::kOffset;
  if (name == "kidnap") return TrialKind::kKidnap;
  if (name == "blackout") return TrialKind::kBlackout;
  if (name == "track") return TrialKind::kTrack;
  throw ParameterError("--kind " + name + ": global, offset, kidnap, blackout or track expected");
}

namespace {

/// Makes the simulator of a random flight. In a narrow building a seed may find no flight; then it
/// tries up to four other seeds.
std::unique_ptr<Simulator> flight(const std::string& file, uint64_t seed, double rate,
                                  size_t images) {
  constexpr int kAttempts = 5;
  for (int attempt = 0;; ++attempt) {
    Scenario scenario = Scenario::fromYamlFile(file);
    scenario.seed = seed + 1000003 * static_cast<uint64_t>(attempt);
    scenario.rate = rate;
    scenario.random_duration = static_cast<double>(images) / rate + 0.5;
    try {
      return std::make_unique<Simulator>(scenario);
    } catch (const InputError&) {
      if (attempt + 1 == kAttempts) throw;
    }
  }
}

}  // namespace

TrialFlight::TrialFlight(const std::string& scenario, TrialKind kind, uint64_t seed, double rate,
                         size_t images, size_t event, double blackout_seconds, double drift)
    : kind_(kind),
      rate_(rate),
      drift_(drift),
      images_(images),
      event_(event),
      dark_(static_cast<size_t>(std::lround(blackout_seconds * rate))),
      random_(seed * 31 + 7),
      first_(flight(scenario, seed, rate, images)),
      drift_direction_(random_.direction()) {
  if (kind == TrialKind::kKidnap)
    second_ = flight(scenario, seed + 500000, rate, images - std::min(images, event));
}

bool TrialFlight::next(RecordedFrame* frame) {
  if (taken_ >= images_) return false;
  const bool carried = kind_ == TrialKind::kKidnap && taken_ >= event_;
  Simulator& simulator = carried ? *second_ : *first_;
  simulator.next(frame);
  // After the robot was carried away, the first increment of the odometry says that it did not
  // move.
  const bool arrives = carried && taken_ == event_;
  Pose increment = Pose::Identity();
  if (last_raw_ && !arrives) increment = last_raw_->inverse() * *frame->odometry;
  last_raw_ = frame->odometry;
  const bool dark = kind_ == TrialKind::kBlackout && taken_ >= event_ && taken_ < event_ + dark_;
  if (dark) {
    increment.translation() += drift_ / static_cast<double>(dark_) * drift_direction_;
    frame->color.setTo(0);
  }
  odometry_ = normalized(odometry_ * increment);
  frame->odometry = odometry_;
  frame->time = static_cast<double>(taken_++) / rate_;
  return true;
}

}  // namespace edge_mcl
