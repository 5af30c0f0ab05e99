/// When the likelihood falls below what it was for long: augmented Monte-Carlo localization (S.
/// Thrun, W. Burgard, D. Fox, "Probabilistic Robotics", 2005, table 8.3; amcl's recovery_alpha_*).
#pragma once

#include <algorithm>
#include <optional>

#include "edge_mcl/core/base/parameters.h"

namespace edge_mcl {

/// A slow and a fast average of a figure that is larger the better the images fit.
class RecoveryAverages {
 public:
  /// @param fit e.g. log-likelihood per line; below zero counts as zero.
  void add(double fit, const FilterParameters& params) {
    fit = std::max(fit, 0.0);
    if (!slow_) slow_ = fast_ = fit;
    *slow_ += params.recovery_alpha_slow * (fit - *slow_);
    *fast_ += params.recovery_alpha_fast * (fit - *fast_);
  }

  /// Probability that the robot is not where its motion should have brought it, 0 to 1:
  /// 1 - fast / slow.
  double shareToInject() const {
    if (!slow_ || *slow_ <= 0) return 0;
    return std::clamp(1 - *fast_ / *slow_, 0.0, 1.0);
  }

 private:
  std::optional<double> slow_, fast_;
};

}  // namespace edge_mcl
