#include "edge_mcl/localization/search/pose_search.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/edges/main_directions.h"
#include "edge_mcl/sim/trial_flight.h"
#include "support/error_text.h"
#include "support/map_views.h"
#include "support/search_setup.h"

namespace edge_mcl {
namespace {

/// A pose that looks like the right one is often a bay away. The bays of the hall are 3.6 m long,
/// and the search does not know this length.
TEST(Search, FindsTheRightBayFromTheOneBesideIt) {
  const std::string scenario = std::string(EDGE_MCL_MAPS) + "/hall_flight.yaml";
  const LocalizationMap map(Scenario::fromYamlFile(scenario).model_file, {});
  const PoseSearch search(map);
  constexpr int kFlights = 20;
  int found = 0;
  for (int seed = 1; seed <= kFlights; ++seed) {
    TrialFlight flight(scenario, TrialKind::kTrack, static_cast<uint64_t>(seed), 10, 2, 1, 1, 0);
    RecordedFrame frame;
    ASSERT_TRUE(flight.next(&frame));
    const auto image = map.prepare(flight.camera(), frame.color, frame.mask, "image");
    const SearchViews seen = search.prepare({{image, Pose::Identity(), 1, nullptr}});
    Pose wrong = *frame.truth;
    wrong.pretranslate(Eigen::Vector3d(wrong.translation().x() < 10 ? 3.6 : -3.6, 0, 0));
    const std::vector<Pose> alike = search.alike(seen, wrong);
    found += std::any_of(alike.begin(), alike.end(), [&](const Pose& pose) {
      return isNear(pose, *frame.truth, 0.2, 1 * kDegree);
    });
  }
  // One of the 20 flights misses the right bay. The required number leaves room for other random
  // flights.
  std::printf("found from the bay beside it: %d of %d\n", found, kFlights);
  EXPECT_GE(found, 17) << "of " << kFlights;
}

/// The camera stands in the furnished rooms, and the base is the camera. The truth is the pose of
/// the rendered image.
class PoseSearchTest : public testing::Test {
 protected:
  static Parameters parameters() {
    Parameters params = quickSearch();
    params.search.max_places = 400;
    params.search.refined = 400;
    params.search.hypotheses = 20;
    params.search.orientations = 100;
    return params;
  }
  /// The up direction at a pose, as an IMU measures it, in the axes of the base.
  static UpReading upOf(const Pose& pose) {
    return {pose.linear().transpose() * Eigen::Vector3d::UnitZ(), 1 * kDegree};
  }
  /// Whether one of the poses is within the accuracy that the header promises, and some centimetres
  /// more.
  bool contain(const std::vector<Pose>& poses) const {
    return std::any_of(poses.begin(), poses.end(),
                       [&](const Pose& pose) { return isNear(pose, truth_, 0.15, 4 * kDegree); });
  }
  /// Checks what holds for the result of every search.
  void expectUsable(const PoseSearch& search, const std::vector<Pose>& poses) const {
    EXPECT_FALSE(poses.empty());
    EXPECT_LE(poses.size(), 2u * static_cast<size_t>(map_.params().search.hypotheses));
    for (size_t a = 0; a < poses.size(); ++a) {
      EXPECT_TRUE(search.admits(views_, poses[a]));
      for (size_t b = a + 1; b < poses.size(); ++b)
        EXPECT_FALSE(isNear(poses[a], poses[b], 0.1, 3 * kDegree)) << a << " " << b;
    }
  }

  const LocalizationMap map_{test::furnishedRooms(), parameters()};
  const std::vector<CameraView> views_{test::viewInRoom(map_)};
  const Pose truth_ = test::roomView();
};

TEST_F(PoseSearchTest, FindsThePoseInTheWholeModelWithAnImu) {
  PoseSearch search(map_);
  RandomSource random(81), again(81);
  const std::vector<Pose> found = search.everywhere(views_, upOf(truth_), &random);
  expectUsable(search, found);
  EXPECT_TRUE(contain(found));
  // A second search with the same seed gives equal bits, however many threads share the work.
  const std::vector<Pose> second = search.everywhere(views_, upOf(truth_), &again);
  ASSERT_EQ(second.size(), found.size());
  for (size_t i = 0; i < found.size(); ++i) EXPECT_EQ(second[i].matrix(), found[i].matrix());
}

/// The camera looks 8 degrees down, so the search has to try orientations.
TEST_F(PoseSearchTest, FindsThePoseInTheWholeModelWithoutAnImu) {
  PoseSearch search(map_);
  RandomSource random(82);
  const std::vector<Pose> found = search.everywhere(views_, std::nullopt, &random);
  expectUsable(search, found);
  EXPECT_TRUE(contain(found));
}

TEST_F(PoseSearchTest, FindsThePoseFromItsOrientation) {
  PoseSearch search(map_);
  RandomSource random(83);
  const Eigen::Matrix3d elsewhere =
      Eigen::AngleAxisd(2, Eigen::Vector3d::UnitZ()) * truth_.linear();
  const std::vector<Pose> found =
      search.everywhere(views_, upOf(truth_), {elsewhere, truth_.linear()}, &random);
  expectUsable(search, found);
  EXPECT_TRUE(contain(found));
  // The refinement turns a pose by some ten degrees at most.
  for (const Pose& pose : found) {
    Pose start = pose;
    start.linear() = elsewhere;
    EXPECT_LT(std::min(rotationAngle(pose, truth_), rotationAngle(pose, start)), 45 * kDegree);
  }
}

/// The guess has an error of 0.5 m and 10 degrees, one standard deviation or somewhat more.
TEST_F(PoseSearchTest, FindsThePoseAroundAGuess) {
  PoseSearch search(map_);
  RandomSource random(84);
  PoseGaussian guess;
  guess.mean = truth_ * expSe3((Twist() << 0.3, -0.1, 0.35, 0.02, 0.17, -0.02).finished());
  guess.covariance.diagonal() << 0.1, 0.1, 0.1, 0.02, 0.02, 0.02;
  for (const bool with_imu : {true, false}) {
    const auto up = with_imu ? std::optional<UpReading>(upOf(truth_)) : std::nullopt;
    const std::vector<Pose> found = search.around(views_, guess, up, &random);
    expectUsable(search, found);
    EXPECT_TRUE(contain(found)) << with_imu;
    // No pose is farther away than the Gaussian reaches.
    for (const Pose& pose : found)
      EXPECT_LT((pose.translation() - guess.mean.translation()).norm(), 2.5);
  }
}

/// The camera hangs 0.3 m ahead of the base, which is x forward and z up.
TEST_F(PoseSearchTest, TheExtrinsicsAreUsed) {
  const Pose T_base_camera = Pose(Eigen::Translation3d(0.3, 0, -0.1)) * opticalOnBody();
  const Pose base = truth_ * T_base_camera.inverse();
  const std::vector<CameraView> mounted{test::viewInRoom(map_, truth_, T_base_camera)};
  PoseSearch search(map_);
  RandomSource random(85);
  const std::vector<Pose> found = search.everywhere(mounted, upOf(base), &random);
  EXPECT_TRUE(std::any_of(found.begin(), found.end(),
                          [&](const Pose& pose) { return isNear(pose, base, 0.15, 4 * kDegree); }));
}

TEST_F(PoseSearchTest, ACameraInAWallIsNotAdmitted) {
  const PoseSearch search(map_);
  const auto at = [](double x, double y, double z) {
    Pose pose = Pose::Identity();
    pose.translation() = Eigen::Vector3d(x, y, z);
    return pose;
  };
  EXPECT_TRUE(search.admits(views_, at(2, 2.5, 1.4)));
  EXPECT_FALSE(search.admits(views_, at(4, 1, 1.4)));      // in the wall between the rooms
  EXPECT_FALSE(search.admits(views_, at(2, 2.5, 2.599)));  // at the ceiling
  EXPECT_FALSE(search.admits(views_, at(-3, 2.5, 1.4)));   // outside
  // The base is in the room, but the second camera is 2 m to the right, in the wall.
  std::vector<CameraView> rig = views_;
  rig.push_back(views_.front());
  rig.back().T_base_camera = at(2, 0, 0);
  EXPECT_FALSE(search.admits(rig, at(2, 1, 1.4)));
  EXPECT_TRUE(search.admits(rig, at(1, 2.5, 1.4)));
}

TEST_F(PoseSearchTest, WithoutAReadingThePriorIsWideInAllAxes) {
  const PoseSearch search(map_);
  const PoseGaussian prior = search.looseAround(truth_, std::nullopt);
  EXPECT_EQ(prior.mean.matrix(), truth_.matrix());
  EXPECT_TRUE(prior.covariance.isDiagonal());
  EXPECT_GE(std::sqrt(prior.covariance.diagonal().head<3>().minCoeff()), 0.2);
  EXPECT_GE(std::sqrt(prior.covariance.diagonal().tail<3>().minCoeff()), 10 * kDegree);
}

/// The reading is turned by 0.1 rad against the pose. The mean of the prior must agree with the
/// reading. Its tilt has the sigma of the reading, but not less than `search.tilt_sigma_deg`.
TEST_F(PoseSearchTest, AReadingNarrowsRollAndPitchOfThePrior) {
  const PoseSearch search(map_);
  const double least = map_.params().search.tilt_sigma_deg * kDegree;
  for (const double sigma : {0.1 * least, 3 * least}) {
    UpReading up = upOf(truth_);
    up.up_base = expSo3(0.1 * up.up_base.unitOrthogonal()) * up.up_base;
    up.sigma = sigma;
    const PoseGaussian prior = search.looseAround(truth_, up);
    EXPECT_EQ(prior.mean.translation(), truth_.translation());
    EXPECT_LT((prior.mean.linear() * up.up_base - Eigen::Vector3d::UnitZ()).norm(), 1e-9);
    const Eigen::Matrix3d turn = prior.covariance.bottomRightCorner<3, 3>();
    const Eigen::Vector3d level = up.up_base.unitOrthogonal();
    EXPECT_NEAR(std::sqrt(level.dot(turn * level)), std::max(sigma, least), 1e-9);
    EXPECT_GE(std::sqrt(up.up_base.dot(turn * up.up_base)), 10 * kDegree);
  }
}

TEST_F(PoseSearchTest, PreparesOneEntryPerView) {
  const PoseSearch search(map_);
  const SearchViews seen = search.prepare({CameraView(), views_.front()});
  ASSERT_EQ(seen.views.size(), 2u);
  ASSERT_EQ(seen.small.size(), 2u);
  ASSERT_EQ(seen.contours.size(), 2u);
  EXPECT_EQ(seen.small[0], nullptr);
  EXPECT_EQ(seen.contours[0], nullptr);
  EXPECT_NE(seen.small[1], nullptr);
  EXPECT_GT(seen.contours[1]->size(), 0u);
  EXPECT_GE(seen.small[1]->camera.width, map_.params().search.small_width);
}

/// The prior has an error of 0.15 m. A refinement in the full image alone searches 16 pixels, which
/// are 0.15 m at a distance of 2 m.
TEST_F(PoseSearchTest, FollowsAPoseOverALargeError) {
  const PoseSearch search(map_);
  const SearchViews seen = search.prepare(views_);
  RandomSource random(86);
  int right = 0;
  for (int i = 0; i < 20; ++i) {
    const Twist error =
        (Twist() << 0.15 * random.direction(), 0.03 * random.direction()).finished();
    const PoseGaussian prior{truth_ * expSe3(error), 0.04 * Matrix6::Identity()};
    const FoundPose found = search.follow(seen, prior);
    right += isNear(found.pose, truth_, 0.02, 0.5 * kDegree) ? 1 : 0;
  }
  EXPECT_GE(right, 18);
}

/// The poses must have the orientation of the given one, and lie on lines through it along the main
/// directions.
TEST_F(PoseSearchTest, LookAlikesLieAlongTheMainDirections) {
  const PoseSearch search(map_);
  const SearchViews seen = search.prepare(views_);
  const std::vector<Pose> alike = search.alike(seen, truth_);
  const std::vector<Eigen::Vector3d> directions = mainDirections(map_.edges());
  EXPECT_FALSE(alike.empty());
  EXPECT_LE(alike.size(), 12u);
  for (const Pose& pose : alike) {
    EXPECT_EQ(pose.linear(), truth_.linear());
    EXPECT_TRUE(search.admits(views_, pose));
    const Eigen::Vector3d way = pose.translation() - truth_.translation();
    EXPECT_GT(way.norm(), 0.3);
    EXPECT_TRUE(std::any_of(directions.begin(), directions.end(), [&](const auto& direction) {
      return way.cross(direction).norm() < 1e-9;
    })) << way.transpose();
  }
  EXPECT_TRUE(search.alike(search.prepare({CameraView()}), truth_).empty());
}

/// A plate has no inside, so there is no place to search.
TEST(PoseSearchErrors, WithoutAnyPlaceTheSearchIsAnError) {
  MeshSoup soup;
  soup.vertices = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  soup.triangles = {{0, 1, 2}, {0, 2, 3}};
  soup.triangle_material = {0, 0};
  const LocalizationMap map(weldMesh(std::move(soup), 1e-6, "test"), {});
  PoseSearch search(map);
  RandomSource random(87);
  test::expectError<InputError>(
      "search.clearance", [&] { search.everywhere({test::darkView(map)}, std::nullopt, &random); });
}

}  // namespace
}  // namespace edge_mcl
