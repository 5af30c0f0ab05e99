// Tests the timeline of a recording.
#include "edge_mcl/viewer/moments/recorded_player.h"

#include <gtest/gtest.h>

#include <functional>
#include <opencv2/imgproc.hpp>
#include <thread>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/sim/simulator.h"
#include "support/view_scenes.h"

namespace edge_mcl {
namespace {

/// A simulated flight as a recording, with another time between images.
class SimulatedInput : public RecordedInput {
 public:
  explicit SimulatedInput(size_t count, double spacing = 0.1)
      : count_(count),
        spacing_(spacing),
        scenario_(Scenario::fromYamlFile(std::string(EDGE_MCL_TEST_DATA) + "small_flight.yaml")),
        simulator_(scenario_) {
    PoseGaussian start;
    start.mean = scenario_.cameraAt(0);
    start.covariance.diagonal().setConstant(1e-3);
    initial_ = start;
  }
  size_t imageCount() const override { return count_; }
  const std::optional<PoseGaussian>& initialPose() const override { return initial_; }
  const Trajectory& truth() const override { return truth_; }
  bool next(LiveInput* input, std::string*) override {
    if (taken_ >= count_) return false;
    RecordedFrame frame;
    simulator_.next(&frame);
    *input = {};
    input->time = spacing_ * static_cast<double>(taken_++);
    input->odometry = frame.odometry;
    LiveInput::CameraImage view;
    view.camera = scenario_.camera;
    view.image = frame.color;
    view.mask = frame.mask;
    input->images.push_back(view);
    truth_.push_back({input->time, "", *frame.truth});
    return true;
  }

 private:
  size_t count_, taken_ = 0;
  double spacing_;
  Scenario scenario_;
  Simulator simulator_;
  std::optional<PoseGaussian> initial_;
  Trajectory truth_;
};

std::unique_ptr<RecordedView> recordedFlight(size_t count, const Eigen::Vector3d& off,
                                             double spacing = 0.1) {
  auto input = std::make_unique<SimulatedInput>(count, spacing);
  Parameters params;
  params.filter.particles = 100;
  params.search.recover = false;
  const auto map = std::make_shared<LocalizationMap>(
      Scenario::fromYamlFile(std::string(EDGE_MCL_TEST_DATA) + "small_flight.yaml").model_file,
      params);
  std::optional<PoseGaussian> start = input->initialPose();
  start->mean.pretranslate(off);
  return std::make_unique<RecordedView>(map, std::move(input), RecordedStart{start, std::nullopt},
                                        50);
}

/// Polls until a condition holds, at most ten seconds. @return whether it holds
bool pollUntil(RecordedPlayer* player, ViewMoment* moment, const std::function<bool()>& done) {
  for (int i = 0; i < 2000; ++i) {
    HistoryView history;
    player->poll(moment, &history, 30);
    if (done()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return false;
}

TEST(RecordedPlayer, PlaysStepsAndGoesBack) {
  RecordedPlayer player(recordedFlight(12, Eigen::Vector3d::Zero()), false);
  player.setSpeed(8);
  ViewMoment moment;
  ASSERT_TRUE(pollUntil(&player, &moment, [&] { return !player.timeline()->playing; }));
  EXPECT_EQ(player.timeline()->position, 11u);
  EXPECT_EQ(player.timeline()->total, 12u);
  EXPECT_NEAR(moment.elapsed, 1.1, 1e-9);
  EXPECT_EQ(moment.state, LocalizerState::kTracking);
  EXPECT_LT((moment.estimate.mean.translation() - moment.truth->translation()).norm(), 0.05);
  const ViewMoment last = moment;
  player.seek(3);
  ASSERT_TRUE(pollUntil(&player, &moment, [&] { return moment.elapsed < 0.35; }));
  EXPECT_NEAR(moment.elapsed, 0.3, 1e-9);
  EXPECT_FALSE(moment.image.empty());
  EXPECT_EQ(moment.particles.size(), 50u);
  HistoryView history;
  player.seek(5);
  ASSERT_TRUE(player.poll(&moment, &history, 30));
  EXPECT_EQ(history.strip.size(), 6u) << "as if the rest had not been yet";
  player.seek(1000);
  ASSERT_TRUE(player.poll(&moment, &history, 30));
  EXPECT_EQ(moment.elapsed, last.elapsed);
}

TEST(RecordedPlayer, JumpsToWhereItIsLost) {
  // The initial pose is wrong by (5, 1.5, 0) m with a small covariance. So the robot is lost within
  // a few seconds.
  RecordedPlayer player(recordedFlight(50, {5, 1.5, 0}), false);
  player.play(false);
  player.findLost();
  ViewMoment moment;
  ASSERT_TRUE(pollUntil(&player, &moment, [&] { return moment.state == LocalizerState::kLost; }));
  const size_t at = player.timeline()->position;
  EXPECT_GT(at, 5u);
  HistoryView history;
  player.seek(at - 1);
  ASSERT_TRUE(player.poll(&moment, &history, 30));
  EXPECT_NE(moment.state, LocalizerState::kLost);
  // There is no further such moment, so the player goes to the end.
  player.seek(at);
  player.findLost();
  ASSERT_TRUE(pollUntil(&player, &moment, [&] { return player.timeline()->position == 49; }));
}

/// Three loops show the six stored moments.
TEST(RecordedPlayer, LoopsWithoutLocalizingAgain) {
  RecordedPlayer player(recordedFlight(6, Eigen::Vector3d::Zero(), 0.03), true);
  player.setSpeed(2);
  ViewMoment moment;
  size_t loops = 0, before = 0;
  ASSERT_TRUE(pollUntil(&player, &moment, [&] {
    const size_t now = player.timeline()->position;
    loops += now < before ? 1 : 0;
    before = now;
    return loops == 3;
  }));
  EXPECT_EQ(player.timeline()->available, 6u);
}

TEST(MomentStore, GivesBackWhatItTookWithinItsMemory) {
  test::SimulatedMoment scene;
  ViewMoment m = scene.moment;
  Pose turned = m.estimate.mean;
  turned.linear() = turned.linear() * expSo3(Eigen::Vector3d(0.1, -0.2, 0.3));
  m.particles = {m.estimate.mean, turned};
  m.weights = {1, 0.5F};
  MomentStore store(1U << 20);
  for (int i = 0; i < 200; ++i) {
    m.elapsed = i;
    store.add(m);
    EXPECT_LE(store.bytes(), 1U << 20);
  }
  ASSERT_EQ(store.size(), 200u);
  const ViewMoment newest = store.get(199), oldest = store.get(0);
  EXPECT_EQ(newest.elapsed, 199);
  EXPECT_LT(rotationAngle(newest.particles[1], turned), 1e-5);
  EXPECT_LT((newest.particles[1].translation() - turned.translation()).norm(), 1e-5);
  cv::Mat difference;
  cv::absdiff(newest.image, m.image, difference);
  EXPECT_LT(cv::mean(difference)[1], 3) << "compressed";
  EXPECT_EQ(cv::countNonZero(newest.mask != m.mask), 0) << "without loss";
  EXPECT_TRUE(oldest.image.empty());
  EXPECT_TRUE(oldest.has_pose);
  EXPECT_THROW(store.get(200), Error);
  // Of an image with 16 bits the upper 8 bits are stored.
  scene.moment.image.convertTo(m.image, CV_16U, 256);
  store.add(m);
  cv::absdiff(store.get(200).image, scene.moment.image, difference);
  EXPECT_LT(cv::mean(difference)[1], 3);
}

TEST(ViewHistory, IsBoundedAndThinsOutLongPaths) {
  ViewHistory history;
  ViewMoment m;
  m.has_pose = true;
  for (size_t i = 0; i < ViewHistory::kMost + 500; ++i) {
    m.time = 0.1 * static_cast<double>(i);
    m.estimate.mean.translation().x() = static_cast<double>(i);
    history.add(m);
  }
  EXPECT_EQ(history.size(), ViewHistory::kMost);
  const HistoryView view = history.view(history.size(), 5);
  EXPECT_EQ(view.strip.size(), 51u);
  EXPECT_LE(view.path.size(), 2100u);
  EXPECT_EQ(view.path.back().x(), static_cast<float>(ViewHistory::kMost + 499));
  EXPECT_TRUE(history.view(0, 5).strip.empty());
}

}  // namespace
}  // namespace edge_mcl
