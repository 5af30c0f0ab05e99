#include "edge_mcl/localization/recorded/recorded_localizer.h"

#include <gtest/gtest.h>

#include <deque>
#include <limits>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/base/parameter_struct.h"
#include "support/map_views.h"

namespace edge_mcl {
namespace {

/// One moment of a recording, and the problem that is reported with it.
struct RecordedMoment {
  LiveInput input;
  std::string problem;
};

/// A recording in memory.
class RecordingInMemory : public RecordedInput {
 public:
  explicit RecordingInMemory(std::deque<RecordedMoment> moments)
      : moments_(std::move(moments)), count_(moments_.size()) {}
  size_t imageCount() const override { return count_; }
  const std::optional<PoseGaussian>& initialPose() const override { return none_; }
  const Trajectory& truth() const override { return truth_; }
  bool next(LiveInput* input, std::string* problem) override {
    if (moments_.empty()) return false;
    *input = moments_.front().input;
    *problem = moments_.front().problem;
    moments_.pop_front();
    return true;
  }

 private:
  std::deque<RecordedMoment> moments_;
  size_t count_;
  std::optional<PoseGaussian> none_;
  Trajectory truth_;
};

/// A camera at rest in the furnished rooms. The base is the camera.
class RecordedLocalizerTest : public testing::Test {
 protected:
  static std::shared_ptr<const LocalizationMap> map() {
    Parameters params;
    params.filter.particles = 100;
    params.search.recover = false;
    return std::make_shared<LocalizationMap>(test::furnishedRooms(), params);
  }
  static RecordedMoment moment(double time, const std::string& problem = "") {
    RecordedMoment result;
    result.input.time = time;
    result.input.odometry = Pose::Identity();
    result.input.images.push_back(
        {test::roomCamera(), test::roomPicture(), {}, Pose::Identity(), "image"});
    result.problem = problem;
    return result;
  }
  static PoseGaussian around(const Pose& pose) { return {pose, 4e-4 * Matrix6::Identity()}; }
  static RecordedLocalizer localizer(const std::deque<RecordedMoment>& moments,
                                     const RecordedStart& start) {
    return {map(), std::make_unique<RecordingInMemory>(moments), start};
  }
};

TEST(TrackingOfRecordings, UsesEveryImageHoweverLittleItShows) {
  TrackingParameters params;
  params.min_visible_samples = 77;
  params.min_evidence = 3.5;
  const TrackingParameters recorded = trackingOfRecordings(params);
  EXPECT_EQ(recorded.min_visible_samples, 0);
  const auto before = describeParameters(params), after = describeParameters(recorded);
  for (size_t i = 0; i < before.size(); ++i) {
    if (before[i].name != "min_visible_samples") {
      EXPECT_EQ(after[i].value, before[i].value) << before[i].name;
    }
  }
}

/// The truth is the pose of the rendered image.
TEST_F(RecordedLocalizerTest, LocalizesMomentAfterMoment) {
  RecordedLocalizer run =
      localizer({moment(1), moment(1.1), moment(1.2)}, {around(test::roomView()), std::nullopt});
  EXPECT_EQ(run.recording().imageCount(), 3u);
  EXPECT_EQ(run.localizer().tracking().min_visible_samples, 0);
  for (const double time : {1.0, 1.1, 1.2}) {
    ASSERT_TRUE(run.next());
    EXPECT_EQ(run.input().time, time);
    EXPECT_TRUE(run.result().updated);
    EXPECT_EQ(run.result().problem, "");
    EXPECT_EQ(run.result().state, LocalizerState::kTracking);
    const Pose& pose = run.result().estimate.mean;
    EXPECT_LT((pose.translation() - test::roomView().translation()).norm(), 0.03);
    EXPECT_GE(run.readingMs(), 0);
  }
  EXPECT_FALSE(run.next());
  EXPECT_FALSE(run.next());
  EXPECT_EQ(run.input().time, 1.2);  // the last moment stays
}

TEST_F(RecordedLocalizerTest, WithoutAPoseItSearches) {
  const RecordedLocalizer run = localizer({moment(1)}, {});
  EXPECT_EQ(run.localizer().state(), LocalizerState::kSearching);
  EXPECT_FALSE(run.localizer().isInitialized());
}

TEST_F(RecordedLocalizerTest, TheUpDirectionIsThatOfTheFirstMomentOnly) {
  const Eigen::Vector3d up = 5 * (test::roomView().linear().transpose() * Eigen::Vector3d::UnitZ());
  RecordedLocalizer run = localizer({moment(1), moment(1.1)}, {around(test::roomView()), up});
  ASSERT_TRUE(run.next());
  ASSERT_TRUE(run.input().up);
  EXPECT_LT((run.input().up->up_base - up.normalized()).norm(), 1e-12);
  ASSERT_TRUE(run.next());
  EXPECT_FALSE(run.input().up);
}

TEST_F(RecordedLocalizerTest, AProblemOfTheRecordingIsReportedAndNotThrown) {
  RecordedMoment broken = moment(1.1, "b.png: cannot be decoded");
  broken.input.images.clear();
  RecordedLocalizer run =
      localizer({moment(1), broken, moment(1.2)}, {around(test::roomView()), std::nullopt});
  ASSERT_TRUE(run.next());
  ASSERT_TRUE(run.next());
  EXPECT_EQ(run.result().problem, "b.png: cannot be decoded");
  EXPECT_FALSE(run.result().updated);
  ASSERT_TRUE(run.next());
  EXPECT_EQ(run.result().problem, "");
  EXPECT_TRUE(run.result().updated);
}

TEST_F(RecordedLocalizerTest, APoseThatIsSetCountsFromTheNextMomentOn) {
  const Pose elsewhere = test::roomView() * Pose(Eigen::Translation3d(0.3, 0, 0));
  RecordedLocalizer run = localizer({moment(1), moment(1.1)}, {around(elsewhere), std::nullopt});
  ASSERT_TRUE(run.next());
  run.setPose(around(test::roomView()));
  ASSERT_TRUE(run.next());
  EXPECT_LT((run.result().estimate.mean.translation() - test::roomView().translation()).norm(),
            0.03);
  PoseGaussian broken;
  broken.mean.translation().x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(run.setPose(broken), InputError);
}

}  // namespace
}  // namespace edge_mcl
