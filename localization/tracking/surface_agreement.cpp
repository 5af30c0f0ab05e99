#include "edge_mcl/localization/tracking/surface_agreement.h"

#include <cmath>

#include "edge_mcl/localization/search/pose_tolerances.h"

namespace edge_mcl {

namespace {

/// A pose that is known to this is compared with the depth. Three standard deviations then move a
/// wall at 3 m by about as much as the smallest thing in front of it, 0.1 to 0.3 m.
constexpr PoseTolerance kNarrow{0.05, 1.5 * kDegree};

/// Fewest pixels that are not in front of the model, and their least share of all that were
/// compared. About 19,000 pixels are compared. A hand before the camera leaves few of them, and
/// these say nothing of the pose.
constexpr double kFewestPixels = 500, kLeastPart = 0.3;

/// The share of an earlier moment holds this long. Slow depth cameras send five images a second.
constexpr double kHolds = 0.3;  // s

}  // namespace

void SurfaceAgreement::begin(double time, const PoseGaussian& predicted) {
  if (has_depth_) {
    last_ = ofMoment();
    last_time_ = time_;
  }
  time_ = time;
  is_narrow_ = !isWiderThan(kNarrow, predicted);
  has_depth_ = false;
  pixels_ = on_model_ = compared_ = 0;
}

void SurfaceAgreement::add(const ForeignPoints& found) {
  has_depth_ = true;
  const double in_front = static_cast<double>(found.points.size());
  const double pixels = static_cast<double>(found.compared) - in_front;
  compared_ += static_cast<double>(found.compared);
  pixels_ += pixels;
  on_model_ += pixels * found.agreement;
}

std::optional<double> SurfaceAgreement::ofMoment() const {
  if (!is_narrow_ || pixels_ < kFewestPixels || pixels_ < kLeastPart * compared_)
    return std::nullopt;
  return on_model_ / pixels_;
}

std::optional<double> SurfaceAgreement::value() const {
  if (has_depth_) return ofMoment();
  return std::abs(time_ - last_time_) <= kHolds ? last_ : std::nullopt;
}

}  // namespace edge_mcl
