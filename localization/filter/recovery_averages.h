/// Detects that the likelihood has fallen below its long-term average, as in augmented Monte-Carlo
/// localization (S. Thrun, W. Burgard, D. Fox, "Probabilistic Robotics", 2005, table 8.3; amcl's
/// recovery_alpha_*).
#pragma once

#include <algorithm>
#include <optional>

#include "edge_mcl/core/base/parameters.h"

namespace edge_mcl {

/// A slow and a fast average of a figure that is larger the better the images fit the pose.
class RecoveryAverages {
 public:
  /// Adds one image. @param fit for example the log-likelihood per line. A value below zero counts
  /// as zero.
  void add(double fit, const FilterParameters& params) {
    fit = std::max(fit, 0.0);
    if (!slow_) slow_ = fast_ = fit;
    *slow_ += params.recovery_alpha_slow * (fit - *slow_);
    *fast_ += params.recovery_alpha_fast * (fit - *fast_);
  }

  /// Share of the particles that should be injected, 0 to 1: 1 - fast / slow. It is 0 before the
  /// first image and when the slow average is 0.
  double shareToInject() const {
    if (!slow_ || *slow_ <= 0) return 0;
    return std::clamp(1 - *fast_ / *slow_, 0.0, 1.0);
  }

 private:
  std::optional<double> slow_, fast_;
};

}  // namespace edge_mcl
