#include "edge_mcl/core/likelihood/reference_likelihood.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/image/edge_field.h"
#include "edge_mcl/core/localization_map.h"
#include "support/room_view.h"

namespace edge_mcl {
namespace {

/// Two vertical model lines at the depth 2 m, at u = 99.9 and u = 219.9, from v = 60 to v = 180.
/// Neighbouring samples are 5 px apart, so each line has 24 samples. Vertical image edges lie at
/// the columns 103 and 216. The edges are set directly, because a detector might take either side
/// of a step.
class TwoLines : public testing::Test {
 protected:
  void prepare(LikelihoodModel model) {
    params_.likelihood.model = model;
    params_.likelihood.sigma = 5;
    params_.likelihood.k = 7;
    params_.likelihood.alpha = 0.5;
    params_.map.sample_step = 0.05;
    MeshSoup soup;
    soup.vertices = {{-0.6f, -0.6f, 2}, {-0.6f, 0.6f, 2}, {0.6f, -0.6f, 2}, {0.6f, 0.6f, 2}};
    soup.lines = {{0, 1}, {2, 3}};
    map_ = std::make_unique<LocalizationMap>(weldMesh(soup, 1e-6, "two lines"), params_);
    edges_.grey = cv::Mat(240, 320, CV_8U, cv::Scalar(0));
    edges_.edges = cv::Mat(240, 320, CV_8U, cv::Scalar(0));
    edges_.gradient_x = cv::Mat(240, 320, CV_16S, cv::Scalar(100));
    edges_.gradient_y = cv::Mat(240, 320, CV_16S, cv::Scalar(0));
    edges_.edges.col(103) = 255;
    edges_.edges.col(216) = 255;
    frame_.camera = test::pinhole(320, 240, 200);
    frame_.camera.fy = 200;
    frame_.camera.cx = 159.9;
    frame_.camera.cy = 120;
    frame_.camera.validate("test");
    frame_.params = params_.likelihood;
    frame_.sample_step = map_->edges().sample_step;
  }
  void makeTable() {
    frame_.table =
        std::make_shared<ScoreTable>(EdgeField(edges_, EdgePixels(edges_), params_.image),
                                     ScoreLevels(params_.image, params_.likelihood));
  }
  PoseScore flowAt(const Pose& pose) const {
    return paperFlowScore(frame_, edges_, params_.image, map_->visibility(), pose);
  }

  Parameters params_;
  std::unique_ptr<LocalizationMap> map_;
  EdgeImage edges_;
  LikelihoodFrame frame_;
};

double gaussian(double d) { return std::exp(-d * d / (2 * 5 * 5)); }

/// The search goes along the normal in steps of half a pixel, and rounds to pixels. From 99.9 it
/// meets the column 103 at +3 px (102.9). From 219.9 it meets the column 216 at -3.5 px (216.4).
/// So all distances are known, and the result is equations (1) to (3).
TEST_F(TwoLines, ThePapersFlowAgreesWithTheHandWorkedExample) {
  prepare(LikelihoodModel::kPaper);
  const double l1 = gaussian(3), l2 = gaussian(3.5);
  const PoseScore score = flowAt(Pose::Identity());
  EXPECT_NEAR(score.log_likelihood, std::log(0.5) + 7 * (l1 + l2) / 2, 1e-9);
  EXPECT_EQ(score.line_count, 2);
  EXPECT_FLOAT_EQ(score.sample_weight, 48);
  // Every third sample has the same distances, so the means do not change.
  frame_.thinning = 3;
  const PoseScore thinned = flowAt(Pose::Identity());
  EXPECT_NEAR(thinned.log_likelihood, score.log_likelihood, 1e-9);
  EXPECT_FLOAT_EQ(thinned.sample_weight, 16);
}

/// An edge that is out of reach scores 0, and its line still counts.
TEST_F(TwoLines, ALineWithoutAnImageEdgeCountsWithZero) {
  prepare(LikelihoodModel::kPaper);
  edges_.edges.col(216) = 0;
  const PoseScore score = flowAt(Pose::Identity());
  EXPECT_NEAR(score.log_likelihood, std::log(0.5) + 7 * gaussian(3) / 2, 1e-9);
  EXPECT_EQ(score.line_count, 2);
}

/// A line under the mask, or outside the image, counts neither in the sum nor in the number.
TEST_F(TwoLines, ALineThatIsNotSeenDoesNotCount) {
  prepare(LikelihoodModel::kPaper);
  edges_.ignore = cv::Mat(240, 320, CV_8U, cv::Scalar(0));
  edges_.ignore.colRange(90, 110).setTo(255);
  const PoseScore masked = flowAt(Pose::Identity());
  EXPECT_NEAR(masked.log_likelihood, std::log(0.5) + 7 * gaussian(3.5), 1e-9);
  EXPECT_EQ(masked.line_count, 1);
  edges_.ignore.release();
  // Moved by 1.2 m, the right line is where the left line was.
  const PoseScore aside = flowAt(Pose(Eigen::Translation3d(1.2, 0, 0)));
  EXPECT_NEAR(aside.log_likelihood, std::log(0.5) + 7 * gaussian(3), 1e-9);
  EXPECT_EQ(aside.line_count, 1);
  const PoseScore away = flowAt(Pose(Eigen::Translation3d(0, 0, 5)));
  EXPECT_NEAR(away.log_likelihood, std::log(0.5), 1e-12);
  EXPECT_EQ(away.line_count, 0);
}

/// Near the border the weight of a sample falls to 0 over 4 px. The camera moves down by 0.6 m,
/// which is 60 px. The first sample of each line is then 2.5 px below the first row, and the other
/// samples are farther than 4 px from the border.
TEST_F(TwoLines, TheWeightFadesTowardsTheBorder) {
  prepare(LikelihoodModel::kPaper);
  EXPECT_NEAR(flowAt(Pose(Eigen::Translation3d(0, 0.6, 0))).sample_weight, 2 * (2.5 / 4 + 23),
              1e-3);
}

/// The table holds the score of every pixel, so the truth is worked out from the bytes at the
/// columns 99 and 100, which the line at 99.9 lies between. The image edges fill their columns, and
/// the density of clutter is the same in all rows. The rest is the formula of docs/likelihood.md:
/// n samples of the score r count as n r / (1 + n/s).
TEST_F(TwoLines, TheRobustReferenceAgreesWithTheHandWorkedExample) {
  prepare(LikelihoodModel::kRobust);
  makeTable();
  const ScoreTable& table = *frame_.table;
  const int vertical = table.bins() / 2;
  const auto scoreAt = [&](double u) {
    const int x = static_cast<int>(u);
    const double share = u - x;
    return table.offset() + table.scale() * ((1 - share) * table.code(vertical, x, 120) +
                                             share * table.code(vertical, x + 1, 120));
  };
  const double s = params_.likelihood.line_saturation, n = 24;
  const double sum = n * (scoreAt(99.9) + scoreAt(219.9)) / (1 + n / s), count = 2 * n / (n + s);
  const VisibleSet set = map_->visibility().exact({0, 0, 0});
  const PoseScore score = referenceScore(frame_, set, Pose::Identity());
  // Model vertices are single precision, so pixels have an error of up to 1e-5.
  EXPECT_NEAR(
      score.log_likelihood,
      params_.likelihood.scale * sum / (1 + params_.likelihood.line_correlation * (count - 1)),
      1e-3);
  EXPECT_NEAR(score.line_count, count, 1e-5);
  EXPECT_NEAR(score.sample_weight, 2 * n, 1e-3);
}

/// In the robust model samples closer than the correlation length of 4 px count in part. At twice
/// the depth the spacing is 2.5 px.
TEST_F(TwoLines, CloseSamplesCountInPart) {
  prepare(LikelihoodModel::kRobust);
  makeTable();
  const Pose back(Eigen::Translation3d(0, 0, -2));
  const VisibleSet set = map_->visibility().exact(back.translation());
  EXPECT_NEAR(referenceScore(frame_, set, back).sample_weight, 48 * 2.5 / 4, 1e-3);
  // Without two thirds of the samples the spacing is 7.5 px.
  frame_.thinning = 3;
  EXPECT_NEAR(referenceScore(frame_, set, back).sample_weight, 16, 1e-3);
}

TEST_F(TwoLines, TheReferenceNeedsATableOrAPicture) {
  prepare(LikelihoodModel::kRobust);
  const VisibleSet set = map_->visibility().exact({0, 0, 0});
  EXPECT_THROW(referenceScore(frame_, set, Pose::Identity()), Error);
  frame_.picture =
      std::make_shared<Picture>(edges_.grey, cv::Mat(), params_.image,
                                std::make_shared<ScoreLevels>(params_.image, params_.likelihood));
  EXPECT_NO_THROW(referenceScore(frame_, set, Pose::Identity()));
}

/// The two functions share the sums over lines, but not the scores: one reads the table, the other
/// one searches along every normal. Their distances differ by up to 1 px, and for sigma = 2 px a
/// score changes by up to 0.3 per pixel. The mean over all lines may change by a third of that.
TEST(ReferenceLikelihood, AgreesWithThePapersFlowInARoom) {
  Parameters params;
  params.likelihood.model = LikelihoodModel::kPaper;
  params.image.reference_width = 0;  // the flow takes lengths as they are
  const LocalizationMap map(test::furnishedRooms(), params);
  const auto image = map.prepare(test::roomCamera(), test::roomPicture(), {}, "room");
  double worst = 0;
  for (const Pose& pose : test::posesAroundView(40, 0.02, 0.01, 5)) {
    const VisibleSet set = map.visibility().exact(pose.translation());
    const PoseScore table = referenceScore(image->frame, set, pose);
    const PoseScore flow =
        paperFlowScore(image->frame, image->edges, params.image, map.visibility(), pose);
    EXPECT_NEAR(table.sample_weight, flow.sample_weight, 1e-3 * flow.sample_weight);
    worst =
        std::max(worst, std::abs(table.log_likelihood - flow.log_likelihood) / params.likelihood.k);
  }
  std::printf("mean scores of lines differ by at most %.3f\n", worst);
  EXPECT_LT(worst, 0.1);
}

}  // namespace
}  // namespace edge_mcl
