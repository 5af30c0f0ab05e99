// Tests the search for a pose without a first guess, and after the pose was lost.
#include <gtest/gtest.h>
#include <tbb/global_control.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "edge_mcl/core/base/angles.h"
#include "edge_mcl/core/base/error.h"
#include "edge_mcl/localization/search/global_localizer.h"
#include "edge_mcl/localization/tracking/live_localizer.h"
#include "edge_mcl/sim/simulator.h"
#include "support/flight_input.h"
#include "support/search_setup.h"

namespace edge_mcl {
namespace {

using test::inputOf;
using test::isRight;
namespace fs = std::filesystem;
const std::string kData = EDGE_MCL_TEST_DATA;

/// A guess with an error of up to 1 m and 15 degrees.
PoseGaussian badGuess(const Pose& truth, RandomSource* random) {
  Twist error;
  error.head<3>() = 1.0 * random->uniform() * random->direction();
  error.tail<3>() = 15 * kDegree * random->uniform() * random->direction();
  PoseGaussian guess;
  guess.mean = normalized(truth * expSe3(error));
  guess.covariance.diagonal().head<3>().setConstant(0.25);
  guess.covariance.diagonal().tail<3>().setConstant(7.5 * kDegree * 7.5 * kDegree);
  return guess;
}

/// The truth is the pose of the simulator. After the search every pose must be right.
TEST(Search, FindsTheCameraInTheOfficeAndTracksIt) {
  Scenario scenario = Scenario::fromYamlFile(kData + "small_flight.yaml");
  Simulator simulator(scenario);
  const auto map = std::make_shared<LocalizationMap>(scenario.model_file, quickSearch());
  LiveLocalizer localizer(map);
  localizer.searchEverywhere();
  RandomSource random(5);
  RecordedFrame frame;
  int found = 0, right = 0, after = 0;
  for (size_t i = 0; i < simulator.imageCount(); ++i) {
    simulator.next(&frame);
    const LiveResult r = localizer.process(inputOf(frame, scenario.camera, &random));
    if (!localizer.isInitialized()) {
      EXPECT_EQ(r.state, LocalizerState::kSearching);
      EXPECT_FALSE(r.clusters.empty());
      continue;
    }
    found += r.relocalized ? 1 : 0;
    ++after;
    right += isRight(r.estimate.mean, *frame.truth) ? 1 : 0;
  }
  EXPECT_EQ(found, 1);
  EXPECT_EQ(right, after);
  EXPECT_GT(after, 20) << "of 61 images";
  EXPECT_EQ(localizer.state(), LocalizerState::kTracking);
}

/// Prepared places ten metres apart find nothing, but they give poses. The search that does without
/// them must have its turn.
TEST(Search, FindsTheCameraWherePreparedPlacesDoNot) {
  Scenario scenario = Scenario::fromYamlFile(kData + "small_flight.yaml");
  Simulator simulator(scenario);
  Parameters params = quickSearch();
  params.search.prepared_spacing = 10;
  params.search.candidates = 10;
  params.search.store_places = false;
  const auto map = std::make_shared<LocalizationMap>(scenario.model_file, params);
  ASSERT_TRUE(map->preparedPlaces());
  LiveLocalizer localizer(map);
  localizer.searchEverywhere();
  RandomSource random(5);
  RecordedFrame frame;
  LiveResult r;
  for (size_t i = 0; i < simulator.imageCount() && !localizer.isInitialized(); ++i) {
    simulator.next(&frame);
    r = localizer.process(inputOf(frame, scenario.camera, &random));
  }
  ASSERT_TRUE(localizer.isInitialized());
  EXPECT_TRUE(isRight(r.estimate.mean, *frame.truth));
}

/// When search and filter come to the same pose in different ways, the pose is trusted after three
/// keyframes.
TEST(Search, ABadGuessIsMadeGoodWithinAFewImages) {
  const Scenario scenario = Scenario::fromYamlFile(kData + "small_flight.yaml");
  const auto map = std::make_shared<LocalizationMap>(scenario.model_file, quickSearch());
  for (const uint64_t seed : {1, 2, 3}) {
    Simulator simulator(scenario);
    LiveLocalizer localizer(map);
    RandomSource random(seed);
    RecordedFrame frame;
    int images = 0;
    do {
      simulator.next(&frame);
      if (images == 0) localizer.setPose(badGuess(*frame.truth, &random));
      localizer.process(inputOf(frame, scenario.camera, &random));
      ++images;
    } while (localizer.state() != LocalizerState::kTracking && images < 61);
    EXPECT_TRUE(isRight(localizer.filter().estimate().mean, *frame.truth)) << "seed " << seed;
    std::printf("seed %d: tracking after %d images\n", static_cast<int>(seed), images);
    // Without the search, the filter has to prove itself for one second, which is 15 images.
    EXPECT_LE(images, 15) << "seed " << seed;
  }
}

TEST(Search, FindsItAgainAfterItWasCarriedElsewhere) {
  Scenario scenario = Scenario::fromYamlFile(kData + "small_flight.yaml");
  Simulator simulator(scenario);
  const auto map = std::make_shared<LocalizationMap>(scenario.model_file, quickSearch());
  LiveLocalizer localizer(map);
  // The start is wrong: it is in the other room, with a small covariance.
  PoseGaussian elsewhere;
  elsewhere.mean = scenario.cameraAt(0);
  elsewhere.mean.pretranslate(Eigen::Vector3d(5, 1.5, 0));
  elsewhere.covariance.diagonal().head<3>().setConstant(0.01);
  elsewhere.covariance.diagonal().tail<3>().setConstant(0.002);
  localizer.setPose(elsewhere);
  RandomSource random(6);
  RecordedFrame frame;
  bool lost = false, relocalized = false;
  for (size_t i = 0; i < simulator.imageCount(); ++i) {
    simulator.next(&frame);
    const LiveResult r = localizer.process(inputOf(frame, scenario.camera, &random));
    lost |= r.state == LocalizerState::kLost;
    relocalized |= r.relocalized;
    if (r.state == LocalizerState::kTracking) {
      EXPECT_TRUE(isRight(r.estimate.mean, *frame.truth)) << "image " << i;
    }
  }
  EXPECT_TRUE(lost);
  EXPECT_TRUE(relocalized);
  EXPECT_EQ(localizer.state(), LocalizerState::kTracking);
}

/// When a recording is played in a loop, the robot is back where it began. When the recording is
/// turned back a little, the robot is not there, and two images may fit this wrong place by chance.
TEST(Search, AfterAClockThatJumpedBackTheInitialPoseHasToProveItself) {
  Scenario scenario = Scenario::fromYamlFile(kData + "small_flight.yaml");
  const auto map = std::make_shared<LocalizationMap>(scenario.model_file, quickSearch());
  LiveLocalizer localizer(map);
  PoseGaussian start;
  start.mean = scenario.cameraAt(0);
  start.covariance.diagonal().head<3>().setConstant(0.01);
  start.covariance.diagonal().tail<3>().setConstant(0.002);
  localizer.setPose(start);
  RandomSource random(6);
  for (const bool again : {false, true}) {
    Simulator simulator(scenario);
    RecordedFrame frame;
    for (int i = 0; i < 40; ++i) {
      simulator.next(&frame);
      const LiveResult r = localizer.process(inputOf(frame, scenario.camera, &random));
      EXPECT_EQ(r.restarted, again && i == 0);
      // The proof takes a second, which is 15 images.
      if (again && i < 14) {
        EXPECT_EQ(r.state, LocalizerState::kConverging) << "image " << i;
      }
    }
    EXPECT_EQ(localizer.state(), LocalizerState::kTracking);
  }
}

/// The search found the pose in the middle of the flight. The flight does not begin there, so the
/// search begins anew.
TEST(Search, AfterAClockThatJumpedBackItBeginsAnewWhereNoPoseWasGiven) {
  Scenario scenario = Scenario::fromYamlFile(kData + "small_flight.yaml");
  const auto map = std::make_shared<LocalizationMap>(scenario.model_file, quickSearch());
  LiveLocalizer localizer(map);
  localizer.searchEverywhere();
  RandomSource random(5);
  Simulator simulator(scenario);
  RecordedFrame frame;
  // The clock must jump back by more than a second. A smaller step is taken for a late image.
  while ((!localizer.isInitialized() || frame.time < 1.5) && simulator.next(&frame))
    localizer.process(inputOf(frame, scenario.camera, &random));
  ASSERT_TRUE(localizer.isInitialized());
  Simulator again(scenario);
  again.next(&frame);
  const LiveResult r = localizer.process(inputOf(frame, scenario.camera, &random));
  EXPECT_TRUE(r.restarted);
  EXPECT_FALSE(localizer.isInitialized());
  EXPECT_EQ(r.state, LocalizerState::kSearching);
}

TEST(Search, LooksFartherThanABadGuessThatIsWrong) {
  Scenario scenario = Scenario::fromYamlFile(kData + "small_flight.yaml");
  Simulator simulator(scenario);
  const auto map = std::make_shared<LocalizationMap>(scenario.model_file, quickSearch());
  LiveLocalizer localizer(map);
  // The guess has a standard deviation of 0.5 m, but the camera is in the other room, ten standard
  // deviations away.
  PoseGaussian guess;
  guess.mean = scenario.cameraAt(0);
  guess.mean.pretranslate(Eigen::Vector3d(5, 1.5, 0));
  guess.covariance.diagonal().head<3>().setConstant(0.25);
  guess.covariance.diagonal().tail<3>().setConstant(0.03);
  localizer.setPose(guess);
  RandomSource random(8);
  RecordedFrame frame;
  for (size_t i = 0; i < simulator.imageCount(); ++i) {
    simulator.next(&frame);
    const LiveResult r = localizer.process(inputOf(frame, scenario.camera, &random));
    if (r.state == LocalizerState::kTracking) {
      EXPECT_TRUE(isRight(r.estimate.mean, *frame.truth)) << "image " << i;
    }
  }
  EXPECT_EQ(localizer.state(), LocalizerState::kTracking);
}

/// No image has an up direction. The search takes roll and pitch from the lost pose.
TEST(Search, WithoutAnImuALostCameraIsTakenToBeAsUprightAsItWas) {
  Scenario scenario = Scenario::fromYamlFile(kData + "small_flight.yaml");
  Simulator simulator(scenario);
  const auto map = std::make_shared<LocalizationMap>(scenario.model_file, quickSearch());
  LiveLocalizer localizer(map);
  PoseGaussian elsewhere;
  elsewhere.mean = scenario.cameraAt(0);
  elsewhere.mean.pretranslate(Eigen::Vector3d(5, 1.5, 0));
  elsewhere.covariance.diagonal().head<3>().setConstant(0.01);
  elsewhere.covariance.diagonal().tail<3>().setConstant(0.002);
  localizer.setPose(elsewhere);
  RandomSource random(6);
  RecordedFrame frame;
  for (size_t i = 0; i < simulator.imageCount(); ++i) {
    simulator.next(&frame);
    LiveInput input = inputOf(frame, scenario.camera, &random);
    input.up.reset();
    const LiveResult r = localizer.process(input);
    if (r.state == LocalizerState::kTracking) {
      EXPECT_TRUE(isRight(r.estimate.mean, *frame.truth)) << "image " << i;
    }
  }
  EXPECT_EQ(localizer.state(), LocalizerState::kTracking);
}

class SearchCues : public testing::TestWithParam<std::pair<const char*, const char*>> {};

/// The search works with the paper's likelihood, with depth alone and with both cues.
TEST_P(SearchCues, FindTheCamera) {
  Scenario scenario = Scenario::fromYamlFile(kData + "small_flight.yaml");
  Simulator simulator(scenario);
  Parameters params = quickSearch();
  params.set(GetParam().first, GetParam().second);
  params.depth.store_field = false;
  const auto map = std::make_shared<LocalizationMap>(scenario.model_file, params);
  LiveLocalizer localizer(map);
  localizer.searchEverywhere();
  RandomSource random(9);
  RecordedFrame frame;
  bool right = true;
  for (size_t i = 0; i < simulator.imageCount() && !localizer.isInitialized(); ++i) {
    simulator.next(&frame);
    LiveInput input = inputOf(frame, scenario.camera, &random);
    if (map->usesDepth()) {
      LiveInput::Depth depth;
      depth.image = {scenario.camera, frame.depth, scenario.depth_scale, "depth", std::nullopt};
      depth.image.mask = {frame.mask, scenario.camera, Pose::Identity()};
      input.depths = {depth};
    }
    const LiveResult r = localizer.process(input);
    right = isRight(r.estimate.mean, *frame.truth);
  }
  EXPECT_TRUE(localizer.isInitialized());
  EXPECT_TRUE(right);
}

INSTANTIATE_TEST_SUITE_P(All, SearchCues,
                         testing::Values(std::pair{"likelihood.model", "paper"},
                                         std::pair{"likelihood.cues", "both"},
                                         std::pair{"likelihood.cues", "depth"}));

/// An empty box looks the same after half a turn. No number of images can tell the two poses apart.
class SymmetricRoom : public testing::Test {
 protected:
  fs::path folder_ = fs::temp_directory_path() / ("edge_mcl_search_" + std::to_string(getpid()));
  void SetUp() override {
    fs::create_directories(folder_);
    std::ofstream(folder_ / "room.obj")
        << "v 0 0 0\nv 5 0 0\nv 5 3 0\nv 0 3 0\nv 0 0 2.5\nv 5 0 2.5\nv 5 3 2.5\nv 0 3 2.5\n"
           "f 1 2 3 4\nf 8 7 6 5\nf 5 6 2 1\nf 6 7 3 2\nf 7 8 4 3\nf 8 5 1 4\n";
    std::ofstream(folder_ / "flight.yaml")
        << "model: room.obj\ncamera: "
        << fs::relative(kData + "small_camera.yaml", folder_).string()
        << "\nrate: 5\npath:\n  - {time: 0, position: [1.5, 1.0, 1.2], yaw_deg: 20}\n"
           "  - {time: 2, position: [2.6, 1.7, 1.4], yaw_deg: 80}\n"
           "  - {time: 4, position: [3.4, 1.2, 1.2], yaw_deg: 140}\n";
  }
  void TearDown() override { fs::remove_all(folder_); }

  /// Searches through a flight in the box. @param truth gets the true pose of every image @return
  /// one report per image
  std::vector<SearchReport> search(std::vector<Pose>* truth) {
    const Scenario scenario = Scenario::fromYamlFile((folder_ / "flight.yaml").string());
    Simulator simulator(scenario);
    const LocalizationMap map(scenario.model_file, quickSearch());
    GlobalLocalizer localizer(map, 1);
    localizer.begin();
    RandomSource random(7);
    RecordedFrame frame;
    std::optional<Pose> last;
    std::vector<SearchReport> reports;
    for (size_t i = 0; i < simulator.imageCount(); ++i) {
      simulator.next(&frame);
      if (last)
        localizer.move(BaseMotion::of(map.params().filter, last->inverse() * *frame.odometry, 0.2));
      last = frame.odometry;
      CameraView view;
      view.image = map.prepare(scenario.camera, frame.color, {}, "image");
      reports.push_back(localizer.process({view}, test::upOf(*frame.truth, &random)));
      truth->push_back(*frame.truth);
    }
    return reports;
  }
};

/// The two best places must be the true pose and the true pose turned by half a turn. The search
/// must not converge.
TEST_F(SymmetricRoom, StaysAmbiguousAndSaysSo) {
  std::vector<Pose> truth;
  const std::vector<SearchReport> reports = search(&truth);
  Pose half_turn = Pose::Identity();
  half_turn.linear() = Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  half_turn.translation() = Eigen::Vector3d(5, 3, 0);
  for (const SearchReport& r : reports) EXPECT_FALSE(r.converged);
  size_t newest = reports.size() - 1;
  while (newest > 0 && !reports[newest].keyframe) --newest;
  const SearchReport& last = reports[newest];
  ASSERT_GE(last.keyframes, 4);
  ASSERT_GE(last.clusters.size(), 2u);
  const auto contains = [&](const Pose& pose) {
    return std::any_of(last.clusters.begin(), last.clusters.begin() + 2,
                       [&](const PoseCluster& c) { return isRight(c.pose, pose); });
  };
  EXPECT_TRUE(contains(truth[newest]));
  EXPECT_TRUE(contains(half_turn * truth[newest]));
}

/// The result must be equal to the last bit.
TEST_F(SymmetricRoom, IsTheSameWhateverTheThreads) {
  std::vector<Pose> truth;
  const std::vector<SearchReport> many = search(&truth);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const std::vector<SearchReport> single = search(&truth);
  for (size_t i = 0; i < many.size(); ++i) {
    EXPECT_EQ(many[i].margin, single[i].margin);
    EXPECT_EQ(many[i].estimate.mean.matrix(), single[i].estimate.mean.matrix());
  }
}

TEST(Search, WithoutAnyPlaceItSaysWhy) {
  MeshSoup soup;
  soup.vertices = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  soup.triangles = {{0, 1, 2}, {0, 2, 3}};
  soup.triangle_material = {0, 0};
  const LocalizationMap map(weldMesh(std::move(soup), 1e-6, "test"), {});
  try {
    map.searchPlaces();
    FAIL() << "a plate has no inside";
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find("search.clearance"), std::string::npos);
  }
}

}  // namespace
}  // namespace edge_mcl
