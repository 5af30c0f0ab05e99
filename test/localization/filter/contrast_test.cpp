#include "edge_mcl/localization/filter/contrast.h"

#include <gtest/gtest.h>

#include "edge_mcl/core/base/random_source.h"
#include "support/room_view.h"
#include "support/scenes.h"

namespace edge_mcl {
namespace {

class Contrast : public testing::Test {
 protected:
  double of(LikelihoodModel model, const Pose& pose) const {
    Parameters params;
    params.likelihood.model = model;
    const LocalizationMap map(test::furnishedRooms(), params);
    const auto image = map.prepare(test::roomCamera(), test::roomPicture(), {}, "room");
    return contrastOf(map, {{image, Pose::Identity(), 1, nullptr}}, pose);
  }
};

/// Of 64 independent normal scores the largest is 2.4 standard deviations above their mean. The
/// right pose must be an outlier, with both likelihoods.
TEST_F(Contrast, OfTheRightPoseIsHigh) {
  EXPECT_GT(of(LikelihoodModel::kRobust, test::roomView()), 6);
  EXPECT_GT(of(LikelihoodModel::kPaper, test::roomView()), 4);
}

/// A pose beside the right one is one of many.
TEST_F(Contrast, OfAnyPoseIsLow) {
  RandomSource random(5);
  for (int i = 0; i < 5; ++i) {
    Twist away;
    away << 0.3 * random.direction(), 0.12 * random.direction();
    EXPECT_LT(of(LikelihoodModel::kRobust, test::roomView() * expSe3(away)), 4) << i;
  }
}

TEST_F(Contrast, WithoutLinesInViewThereIsNone) {
  Pose outside = test::roomView();
  outside.translation() += Eigen::Vector3d(1000, 1000, 1000);
  EXPECT_EQ(of(LikelihoodModel::kRobust, outside), 0);
}

}  // namespace
}  // namespace edge_mcl
