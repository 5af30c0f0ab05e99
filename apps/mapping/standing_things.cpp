#include "apps/mapping/standing_things.h"

#include <algorithm>
#include <utility>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/localization/masks/depth_masker.h"

namespace edge_mcl {

void StandingThings::add(const LiveInput& input, const PoseGaussian& T_map_base) {
  // The localizer has the same limit for masks at a likely pose.
  constexpr double kLeastAgreement = 0.7;
  if (newest_ && input.time <= *newest_) follower_.forget();
  newest_ = input.time;
  std::vector<ForeignDepth> depths;
  for (const LiveInput::Depth& depth : input.depths) {
    ++depths_;
    try {
      DepthMasker::Foreign found =
          DepthMasker::find(map_, depth.image, T_map_base, depth.T_base_camera, false);
      if (found.points.agreement >= kLeastAgreement)
        depths.push_back(
            {depth.image, std::move(found.points), T_map_base.mean * depth.T_base_camera});
      else
        ++refused_;
    } catch (const InputError&) {
      ++refused_;
    }
  }
  if (depths.empty()) return;
  std::vector<ForeignColour> colours;
  for (const LiveInput::CameraImage& view : input.images)
    colours.push_back({view.image, view.camera, T_map_base.mean * view.T_base_camera});
  follower_.update(input.time, depths, colours, map_.visibility().scene(), map_.params().depth);
}

std::vector<StandingThing> StandingThings::all() const {
  std::vector<StandingThing> things;
  for (const ObjectState& object : follower_.objects(newest_.value_or(0)))
    if (!object.is_moving)
      things.push_back({object.number, object.box, object.last_seen - object.still_since});
  return things;
}

std::vector<StandingThing> StandingThings::longerThan(double seconds) const {
  std::vector<StandingThing> things = all();
  things.erase(std::remove_if(things.begin(), things.end(),
                              [&](const StandingThing& t) { return t.stood_for < seconds; }),
               things.end());
  return things;
}

size_t StandingThings::countBelow(double seconds) const {
  const std::vector<StandingThing> things = all();
  return static_cast<size_t>(std::count_if(
      things.begin(), things.end(), [&](const StandingThing& t) { return t.stood_for < seconds; }));
}

}  // namespace edge_mcl
