#include "edge_mcl/localization/lookup/place_lookup.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "edge_mcl/core/base/angles.h"
#include "edge_mcl/localization/search/pose_sharpener.h"
#include "support/map_views.h"

namespace edge_mcl {
namespace {

class PlaceLookup : public testing::Test {
 protected:
  /// Place in the list, from 0, of a pose that a refinement brings to the truth.
  static size_t rankOf(const std::vector<LookupPose>& found, const Pose& truth) {
    return static_cast<size_t>(
        std::find_if(
            found.begin(), found.end(),
            [&](const LookupPose& p) { return isNear(p.T_map_camera, truth, 0.36, 4 * kDegree); }) -
        found.begin());
  }
  std::vector<LookupPose> lookedUp(const KnownUp& up, size_t most,
                                   const std::function<bool(const Eigen::Vector3d&)>& filter = {}) {
    const CameraView view = test::viewInRoom(map_);
    return lookUp(*places_, view.image->edges, test::roomCamera(), up, most, filter);
  }
  KnownUp upOfTruth() const {
    return {truth_.linear().transpose() * Eigen::Vector3d::UnitZ(), 2 * kDegree};
  }

  const LocalizationMap map_{test::furnishedRooms(), Parameters()};
  const std::shared_ptr<const PreparedPlaces> places_ = map_.preparedPlaces();
  const Pose truth_ = test::roomView();
};

/// The room has several hundred places with four headings each.
TEST_F(PlaceLookup, TheTruthIsAmongTheBestWithAndWithoutGravity) {
  ASSERT_TRUE(places_);
  ASSERT_GT(places_->count(), 300u);
  EXPECT_LT(rankOf(lookedUp(upOfTruth(), 800), truth_), 60u);
  EXPECT_LT(rankOf(lookedUp({}, 800), truth_), 60u);
}

TEST_F(PlaceLookup, ScoresFallAndTheNumberIsKept) {
  const std::vector<LookupPose> found = lookedUp(upOfTruth(), 50);
  ASSERT_EQ(found.size(), 50u);
  EXPECT_TRUE(std::is_sorted(found.begin(), found.end(),
                             [](const auto& a, const auto& b) { return a.score > b.score; }));
  for (const LookupPose& p : found) EXPECT_NEAR(p.T_map_camera.linear().determinant(), 1, 1e-9);
}

TEST_F(PlaceLookup, OnlyWantedPlacesCount) {
  const auto is_second_room = [](const Eigen::Vector3d& p) { return p.x() > 4.2; };
  const std::vector<LookupPose> found = lookedUp(upOfTruth(), 100, is_second_room);
  ASSERT_FALSE(found.empty());
  for (const LookupPose& p : found) EXPECT_GT(p.T_map_camera.translation().x(), 4.2);
}

TEST_F(PlaceLookup, AnImageWithoutLinesHasNoAnswer) {
  const CameraView dark = test::darkView(map_);
  EXPECT_TRUE(lookUp(*places_, dark.image->edges, test::roomCamera(), upOfTruth(), 100).empty());
}

}  // namespace
}  // namespace edge_mcl
