/// Collects the things of a recording that stand where the model has nothing.
#pragma once

#include <optional>
#include <vector>

#include "edge_mcl/audit/map_additions.h"
#include "edge_mcl/core/localization_map.h"
#include "edge_mcl/localization/objects/object_follower.h"
#include "edge_mcl/localization/tracking/live_localizer.h"

namespace edge_mcl {

/// Follows what stands in front of the model, by the depth images of trusted moments.
class StandingThings {
 public:
  /// @param map must outlive this object.
  explicit StandingThings(const LocalizationMap& map) : map_(map) {}

  /// Adds a moment. When the clock goes back, everything is forgotten.
  /// @param T_map_base trusted, with its covariance
  void add(const LiveInput& input, const PoseGaussian& T_map_base);

  /// Number of the depth images, and of those that do not belong to the model or cannot be used:
  /// they have another scale, size or mounting.
  size_t depths() const { return depths_; }
  size_t refused() const { return refused_; }

  /// The things that stood at one place, also out of view, for at least this time, s.
  std::vector<StandingThing> longerThan(double seconds) const;
  /// Number of the things that stood for a shorter time.
  size_t countBelow(double seconds) const;

 private:
  std::vector<StandingThing> all() const;

  const LocalizationMap& map_;
  ObjectFollower follower_;
  std::optional<double> newest_;  // s
  size_t depths_ = 0, refused_ = 0;
};

}  // namespace edge_mcl
