#include "edge_mcl/localization/tracking/focal_check.h"

#include <gtest/gtest.h>

#include "support/map_views.h"

namespace edge_mcl {
namespace {

CameraModel scaledCamera(double factor) {
  CameraModel camera = test::roomCamera();
  camera.fx *= factor;
  camera.fy *= factor;
  camera.validate("wrong camera");
  return camera;
}

/// The factors that some moments tell, when the pose is the best one with the wrong calibration.
std::vector<double> told(const LocalizationMap& map, double factor, double hint,
                         const cv::Mat& image) {
  const CameraModel camera = scaledCamera(factor);
  const std::vector<CameraView> views{
      {map.prepare(camera, image, {}, "room"), Pose::Identity(), 1, nullptr}};
  const Pose pose = map.refine(views, test::roomView(), std::nullopt).pose;
  FocalCheck check;
  std::vector<double> factors;
  for (int i = 0; i < 20; ++i)
    if (const auto found = check.look({map, image, {}, Pose::Identity(), pose}, camera, hint, i))
      factors.push_back(*found);
  return factors;
}

TEST(FocalCheck, TellsOnceHowFarAFocalLengthIsOff) {
  const LocalizationMap map(test::furnishedRooms(), Parameters());
  for (const double wrong : {0.91, 0.95, 1.05, 1.09}) {
    const auto factors = told(map, wrong, wrong > 1 ? -0.01 : 0.01, test::roomPicture());
    ASSERT_EQ(factors.size(), 1U) << wrong;
    // The nearest of the errors that are tried is at most 0.8 % away, the next one 2.4 %.
    EXPECT_LT((factors[0] - 1) * (wrong - 1), 0) << wrong;
    EXPECT_LT(std::abs(factors[0] * wrong - 1), 0.02) << wrong;
  }
}

TEST(FocalCheck, IsSilentWhereTheFocalLengthIsRight) {
  const LocalizationMap map(test::furnishedRooms(), Parameters());
  for (const double hint : {-0.01, 0.01})
    EXPECT_TRUE(told(map, 1, hint, test::roomPicture()).empty()) << hint;
}

/// Without a hint no time is spent. A dark image and neighbouring images tell nothing.
TEST(FocalCheck, NeedsAHintAndImagesWithEdges) {
  const LocalizationMap map(test::furnishedRooms(), Parameters());
  EXPECT_TRUE(told(map, 1.05, -0.001, test::roomPicture()).empty());
  const cv::Mat dark(test::roomCamera().height, test::roomCamera().width, CV_8U, cv::Scalar(0));
  EXPECT_TRUE(told(map, 1.05, -0.01, dark).empty());
  FocalCheck check;
  const CameraModel camera = scaledCamera(1.05);
  for (int i = 0; i < 20; ++i)
    EXPECT_FALSE(check.look({map, test::roomPicture(), {}, Pose::Identity(), test::roomView()},
                            camera, -0.01, 1 + 1e-3 * i));
}

}  // namespace
}  // namespace edge_mcl
