#include "edge_mcl/localization/search/small_image.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>

#include "edge_mcl/core/base/parameter_struct.h"
#include "edge_mcl/sim/simulator.h"
#include "support/map_views.h"

namespace edge_mcl {
namespace {

const std::string kData = EDGE_MCL_TEST_DATA;

/// The truth is the projection into the full image.
TEST(SmallImage, PixelsAreThoseOfTheFullImage) {
  const Scenario scenario = Scenario::fromYamlFile(kData + "small_flight.yaml");
  Simulator simulator(scenario);
  RecordedFrame frame;
  simulator.next(&frame);
  const LocalizationMap map(scenario.model_file, {});
  const auto full = map.prepare(scenario.camera, frame.color, frame.mask, "image");
  const SmallImages images(map.params(), 160, map.edges().sample_step, 1);
  const auto small = images.make(*full);
  ASSERT_EQ(small->camera.width, 160);
  ASSERT_EQ(small->camera.height, 120);
  // The centre of the top-left pixel is (0, 0). So the centre of a block of 2 x 2 pixels is (0.5,
  // 0.5).
  for (const Eigen::Vector3d& p :
       {Eigen::Vector3d(0.1, -0.2, 1), Eigen::Vector3d(-0.4, 0.3, 1.2)}) {
    Eigen::Vector2d a, b;
    ASSERT_TRUE(scenario.camera.project(p, &a) && small->camera.project(p, &b));
    EXPECT_NEAR(b.x(), (a.x() + 0.5) / 2 - 0.5, 1e-9);
    EXPECT_NEAR(b.y(), (a.y() + 0.5) / 2 - 0.5, 1e-9);
  }
  EXPECT_GT(small->edges.edgeCount(), 200u);
}

TEST(SearchLikelihood, DiffersFromTheFiltersInCorrelationAndScaleOnly) {
  Parameters params;
  params.likelihood.line_correlation = 0.6;
  params.likelihood.scale = 9;
  params.search.line_correlation = 0.05;
  LikelihoodParameters search = searchLikelihood(params);
  EXPECT_EQ(search.line_correlation, 0.05);
  EXPECT_GT(search.scale, 0);
  EXPECT_LT(search.scale, 9);
  search.line_correlation = 0.6;
  search.scale = 9;
  const auto a = describeParameters(search), b = describeParameters(params.likelihood);
  for (size_t i = 0; i < a.size(); ++i) EXPECT_EQ(a[i].value, b[i].value) << a[i].name;
}

/// A picture of the furnished rooms, 320 x 240 pixels.
class SmallImageInRoom : public testing::Test {
 protected:
  const LocalizationMap map_{test::furnishedRooms(), Parameters()};
  const double step_ = map_.edges().sample_step;

  std::shared_ptr<const SmallImage> make(int width, uint32_t thinning = 1,
                                         const cv::Mat& mask = {}) const {
    const auto full = map_.prepare(test::roomCamera(), test::roomPicture(), mask, "room");
    return SmallImages(map_.params(), width, step_, thinning).make(*full);
  }
};

/// The factor is the largest whole number that leaves the smallest width, or 1.
TEST_F(SmallImageInRoom, TheFactorIsAWholeNumber) {
  struct Case {
    int width, factor;
  };
  for (const Case& c : {Case{320, 1}, Case{400, 1}, Case{160, 2}, Case{159, 2}, Case{100, 3}}) {
    const auto small = make(c.width);
    EXPECT_EQ(small->camera.width, 320 / c.factor) << c.width;
    EXPECT_EQ(small->camera.height, 240 / c.factor) << c.width;
    EXPECT_EQ(small->edges.grey.size(), cv::Size(320 / c.factor, 240 / c.factor));
    EXPECT_NEAR(small->camera.fx, test::roomCamera().fx / c.factor, 1e-9);
  }
}

/// The truth is the plain mean of every block of 3 x 3 pixels.
TEST_F(SmallImageInRoom, EveryPixelIsTheMeanOfItsBlock) {
  const auto small = make(100);
  const cv::Mat& grey = small->edges.grey;
  for (int y = 0; y < grey.rows; ++y)
    for (int x = 0; x < grey.cols; ++x) {
      const double mean = cv::mean(test::roomPicture()(cv::Rect(3 * x, 3 * y, 3, 3)))[0];
      // Half a grey level for rounding.
      ASSERT_NEAR(grey.at<uint8_t>(y, x), mean, 0.51) << x << " " << y;
    }
}

TEST_F(SmallImageInRoom, UnderTheMaskThereAreNoEdges) {
  cv::Mat mask(240, 320, CV_8U, cv::Scalar(0));
  mask.colRange(0, 160) = 255;
  const auto bare = make(160), masked = make(160, 1, mask);
  EXPECT_GT(cv::countNonZero(bare->edges.edges.colRange(0, 80)), 100);
  EXPECT_EQ(cv::countNonZero(masked->edges.edges.colRange(0, 80)), 0);
  // The mask grows by 5 pixels in the full image and 2 in the small one, and the blur reaches some
  // more. The edge threshold follows the rest of the image, so the edges need not be equal there.
  EXPECT_GT(cv::countNonZero(masked->edges.edges.colRange(90, 160)), 100);
}

TEST_F(SmallImageInRoom, TheSampleStepIsTheStepOfTheThinnedSets) {
  const auto small = make(160, 4);
  for (const LikelihoodFrame* frame : {&small->broad, &small->sharp}) {
    EXPECT_DOUBLE_EQ(frame->sample_step, 4 * step_);
    EXPECT_EQ(frame->camera.width, 160);
    EXPECT_EQ(frame->params.model, LikelihoodModel::kRobust);
  }
}

/// Both likelihoods must prefer the true pose to poses 0.3 m away. A pose with a small error loses
/// a larger share of its score in the sharp likelihood than in the broad one.
TEST_F(SmallImageInRoom, TheBroadLikelihoodForgivesMoreThanTheSharpOne) {
  const auto small = make(160);
  const Pose truth = test::roomView();
  const VisibleSet visible = map_.visibility().exact(truth.translation());
  const auto scoreOf = [&](const LikelihoodFrame& frame, double aside) {
    const Pose pose = truth * Pose(Eigen::Translation3d(aside, 0, 0));
    return evaluateWithVisibleSet(frame, visible, {pose}).front().log_likelihood;
  };
  for (const LikelihoodFrame* frame : {&small->broad, &small->sharp})
    for (const double aside : {-0.3, 0.3}) EXPECT_GT(scoreOf(*frame, 0), scoreOf(*frame, aside));
  for (const double aside : {-0.05, 0.05})
    EXPECT_GT(scoreOf(small->broad, aside) / scoreOf(small->broad, 0),
              scoreOf(small->sharp, aside) / scoreOf(small->sharp, 0));
}

/// Every start has an error of 0.2 m and 1.7 degrees. The truth is the pose of the rendered
/// picture.
TEST_F(SmallImageInRoom, TheRefinerCorrectsALargeError) {
  const auto full = map_.prepare(test::roomCamera(), test::roomPicture(), {}, "room");
  const SmallImages images(map_.params(), 160, step_, 1);
  const auto small = images.make(*full);
  const Pose truth = test::roomView();
  RandomSource random(61);
  constexpr int kStarts = 40;
  int right = 0;
  for (int i = 0; i < kStarts; ++i) {
    const Pose start =
        truth * expSe3((Twist() << 0.2 * random.direction(), 0.03 * random.direction()).finished());
    RefinementView view;
    view.camera = &small->camera;
    view.image = &small->edges;
    view.pixels = &small->pixels;
    view.visible = std::make_shared<const VisibleSet>(map_.visibility().exact(start.translation()));
    const Pose found = images.refiner().refine({view}, start, std::nullopt, {10, 400}).pose;
    // A pixel of the reduced image is 2 cm wide at a distance of 2 m.
    right += (found.translation() - truth.translation()).norm() < 0.03 ? 1 : 0;
  }
  // Single starts may settle on wrong lines. Of 100 starts about 97 are right.
  EXPECT_GE(right, 36) << "of " << kStarts;
}

}  // namespace
}  // namespace edge_mcl
