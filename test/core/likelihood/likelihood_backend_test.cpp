#include "edge_mcl/core/likelihood/likelihood_backend.h"

#include <gtest/gtest.h>

#include <cmath>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/base/random_source.h"
#include "edge_mcl/core/image/edge_field.h"
#include "support/error_text.h"
#include "support/scenes.h"

namespace edge_mcl {
namespace {

using test::contains;
using test::errorText;

LikelihoodParameters paramsOf(LikelihoodModel model) {
  LikelihoodParameters params;
  params.model = model;
  return params;
}

/// The truth is docs/likelihood.md: the sum of the scores of m lines, times the scale, divided by
/// 1 + (m - 1) rho.
TEST(CombineLines, OfTheRobustModelDividesByTheDesignEffect) {
  LikelihoodParameters params = paramsOf(LikelihoodModel::kRobust);
  params.scale = 5;
  params.line_correlation = 0.25;
  EXPECT_DOUBLE_EQ(combineLines(params, 12, 9), 5 * 12 / (1 + 8 * 0.25));
  // Less than one line is not made larger.
  EXPECT_DOUBLE_EQ(combineLines(params, 12, 0.3), 5 * 12);
  EXPECT_EQ(combineLines(params, 0, 0), 0);
  params.line_correlation = 0;  // the scores are added
  EXPECT_DOUBLE_EQ(combineLines(params, 12, 9), 5 * 12);
  params.line_correlation = 1;  // the scores are averaged
  EXPECT_DOUBLE_EQ(combineLines(params, 12, 9), 5 * 12 / 9.0);
}

/// The truth is the logarithm of equation (3), W = alpha exp(k S / m).
TEST(CombineLines, OfThePaperIsTheLogarithmOfEquation3) {
  LikelihoodParameters params = paramsOf(LikelihoodModel::kPaper);
  params.alpha = 0.3;
  params.k = 7;
  EXPECT_DOUBLE_EQ(combineLines(params, 3, 4), std::log(0.3) + 7 * 0.75);
  EXPECT_DOUBLE_EQ(combineLines(params, 0, 0), std::log(0.3));  // without lines W is alpha
}

/// The mean score of a line is computed back from the total. So it must be the sum divided by the
/// number of lines.
TEST(ScorePerLine, IsTheMeanBehindTheTotal) {
  RandomSource random(1);
  for (const LikelihoodModel model : {LikelihoodModel::kRobust, LikelihoodModel::kPaper})
    for (int i = 0; i < 200; ++i) {
      LikelihoodParameters params = paramsOf(model);
      params.scale = 0.1 + 10 * random.uniform();
      params.line_correlation = random.uniform();
      params.alpha = 0.1 + random.uniform();
      params.k = 1 + 100 * random.uniform();
      const double count = 0.01 + 30 * random.uniform(), sum = 10 * random.normal();
      const double total = combineLines(params, sum, count);
      // Rounding of double precision; the total may be a hundred times as large.
      EXPECT_NEAR(scorePerLine(params, total, count), sum / count,
                  1e-10 * (1 + std::abs(sum / count)));
      EXPECT_EQ(scorePerLine(params, combineLines(params, 0, 0), 0), 0);
    }
}

TEST(PoseScore, ItsScorePerLineIsTheSumDividedByTheLines) {
  PoseScore score;
  EXPECT_EQ(score.scorePerLine(), 0);
  score.line_score_sum = 6;
  score.line_count = 4;
  EXPECT_EQ(score.scorePerLine(), 1.5);
}

/// In the robust model the scale is step * thinning / correlation length, in pixels: times the
/// pixels per metre it gives the spacing in correlation lengths.
TEST(SpacingScale, OfTheRobustModelMeasuresInCorrelationLengths) {
  LikelihoodFrame frame;
  frame.camera = test::pinhole();
  frame.params = paramsOf(LikelihoodModel::kRobust);
  frame.params.correlation_length = 4;
  frame.sample_step = 0.03;
  EXPECT_DOUBLE_EQ(spacingScale(frame), 0.03 / 4);
  frame.thinning = 5;
  EXPECT_DOUBLE_EQ(spacingScale(frame), 5 * 0.03 / 4);
}

/// In the paper's model only edges that are seen within about one degree of end-on fade. At a depth
/// of 1 m a line at the angle a to the ray through the image centre moves f sin(a) pixels per
/// metre.
TEST(SpacingScale, OfThePaperFadesEdgesSeenEndOn) {
  LikelihoodFrame frame;
  frame.camera = test::pinhole(640, 480, 500);
  frame.params = paramsOf(LikelihoodModel::kPaper);
  const auto weightAt = [&](double degrees) {
    const double focal = (frame.camera.fx + frame.camera.fy) / 2;
    return std::min(1.0, spacingScale(frame) * focal * std::sin(degrees * M_PI / 180));
  };
  EXPECT_EQ(weightAt(90), 1);
  EXPECT_EQ(weightAt(1.5), 1);
  EXPECT_LT(weightAt(0.7), 1);
  EXPECT_LT(weightAt(0.1), 0.1);
  const double before = spacingScale(frame);
  frame.thinning = 7;  // thinning has no effect
  frame.sample_step = 0.1;
  EXPECT_EQ(spacingScale(frame), before);
}

std::shared_ptr<const ScoreLevels> levels() {
  return std::make_shared<ScoreLevels>(ImageParameters(), LikelihoodParameters());
}

std::shared_ptr<const Picture> blackPicture(int width, int height) {
  return std::make_shared<Picture>(cv::Mat(height, width, CV_8U, cv::Scalar(0)), cv::Mat(),
                                   ImageParameters(), levels());
}

LikelihoodFrame frameOf(int width, int height) {
  LikelihoodFrame frame;
  frame.camera = test::pinhole(width, height, 50);
  return frame;
}

TEST(LikelihoodFrame, MakesItsTableFromThePictureWhenItHasNone) {
  LikelihoodFrame frame = frameOf(64, 48);
  frame.picture = blackPicture(64, 48);
  EXPECT_EQ(frame.tableHere(), frame.picture->table());
  const auto other = blackPicture(64, 48);
  frame.table = other->table();
  EXPECT_EQ(frame.tableHere(), frame.table);
  EXPECT_NE(frame.tableHere(), frame.picture->table());
}

TEST(LikelihoodFrame, WithoutTableAndPictureIsAnError) {
  const LikelihoodFrame frame = frameOf(64, 48);
  EXPECT_TRUE(contains(errorText<Error>([&] { frame.tableHere(); }), "no image table"));
  EXPECT_TRUE(contains(errorText<Error>([&] { checkFrame(frame); }), "no image table"));
  EXPECT_THROW(checkLikelihoodInput(frame, {Pose::Identity()}), Error);
}

TEST(LikelihoodFrame, AnImageOfAnotherSizeIsAnErrorThatNamesBothSizes) {
  LikelihoodFrame frame = frameOf(64, 48);
  frame.picture = blackPicture(64, 48);
  EXPECT_NO_THROW(checkFrame(frame));
  frame.picture = blackPicture(32, 48);
  const auto text = [&] { return errorText<InputError>([&] { checkFrame(frame); }); };
  EXPECT_TRUE(contains(text(), "32x48")) << text();
  EXPECT_TRUE(contains(text(), "64x48")) << text();
  frame.table = frame.picture->table();
  frame.picture = nullptr;
  EXPECT_TRUE(contains(text(), "32x48")) << text();
  EXPECT_THROW(checkLikelihoodInput(frame, {}), InputError);
}

TEST(LikelihoodFrame, APoseThatIsNotFiniteIsAnError) {
  LikelihoodFrame frame = frameOf(64, 48);
  frame.picture = blackPicture(64, 48);
  const Pose good = Pose::Identity();
  EXPECT_NO_THROW(checkLikelihoodInput(frame, {good, good}));
  for (const double value : {double(NAN), double(INFINITY)}) {
    Pose moved = good, turned = good;
    moved.translation().y() = value;
    turned.linear()(1, 2) = value;
    EXPECT_THROW(checkPose(moved), Error);
    EXPECT_THROW(checkPose(turned), Error);
    EXPECT_THROW(checkLikelihoodInput(frame, {good, moved}), Error);
    EXPECT_THROW(checkLikelihoodInput(frame, {good, turned}), Error);
  }
}

/// A backend that only scores poses.
class PlainBackend : public LikelihoodBackend {
 public:
  std::vector<PoseScore> evaluate(const LikelihoodFrame&,
                                  const std::vector<Pose>& poses) const override {
    return std::vector<PoseScore>(poses.size());
  }
  std::string name() const override { return "plain"; }
};

TEST(LikelihoodBackend, NeedsTablesAndIgnoresAPrefetchUnlessItSaysOtherwise) {
  const PlainBackend backend;
  EXPECT_FALSE(backend.makesTables(ImageParameters()));
  EXPECT_NO_THROW(backend.prefetch(LikelihoodFrame()));
}

}  // namespace
}  // namespace edge_mcl
