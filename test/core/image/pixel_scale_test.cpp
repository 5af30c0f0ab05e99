#include "edge_mcl/core/image/pixel_scale.h"

#include <gtest/gtest.h>

#include "edge_mcl/core/base/random_source.h"
#include "edge_mcl/core/localization_map.h"
#include "support/scenes.h"

namespace edge_mcl {
namespace {

TEST(PixelScale, IsTheRatioOfTheWidthsOfImagesOfOneShape) {
  const ImageParameters params;
  EXPECT_DOUBLE_EQ(pixelScale(params, {640, 480}), 1);
  EXPECT_DOUBLE_EQ(pixelScale(params, {320, 240}), 0.5);
  EXPECT_DOUBLE_EQ(pixelScale(params, {1280, 960}), 2);
  EXPECT_DOUBLE_EQ(pixelScale(params, {480, 640}), 1);  // a camera held upright
}

TEST(PixelScale, IsLimited) {
  const ImageParameters params;
  EXPECT_DOUBLE_EQ(pixelScale(params, {40, 30}), 0.5);
  EXPECT_DOUBLE_EQ(pixelScale(params, {6400, 4800}), 4);
  EXPECT_DOUBLE_EQ(pixelScale(params, {0, 0}), 1);
}

TEST(PixelScale, WithoutReferenceParametersHoldForEveryImage) {
  ImageParameters params;
  params.reference_width = 0;
  EXPECT_DOUBLE_EQ(pixelScale(params, {320, 240}), 1);
}

TEST(PixelScale, AScaleOfOneChangesNothing) {
  Parameters params, scaled;
  scaled.image = scaledBy(1, params.image);
  scaled.likelihood = scaledBy(1, params.likelihood);
  EXPECT_EQ(scaled.toYaml(), params.toYaml());
}

/// An edge is one pixel wide. In an image of half the width it takes twice the share of all pixels.
TEST(PixelScale, HalfTheWidthHalvesLengthsAndDoublesTheShareOfEdges) {
  const ImageParameters image = scaledBy(0.5, ImageParameters());
  const ImageParameters full;
  EXPECT_DOUBLE_EQ(image.blur_sigma, full.blur_sigma / 2);
  EXPECT_EQ(image.search_length, full.search_length / 2);
  EXPECT_EQ(image.clutter_window, full.clutter_window / 2);
  EXPECT_DOUBLE_EQ(image.edge_share, 2 * full.edge_share);
  const LikelihoodParameters likelihood = scaledBy(0.5, LikelihoodParameters());
  EXPECT_DOUBLE_EQ(likelihood.sigma, LikelihoodParameters().sigma / 2);
  EXPECT_DOUBLE_EQ(likelihood.correlation_length, LikelihoodParameters().correlation_length / 2);
  EXPECT_DOUBLE_EQ(scaledBy(2, full).edge_share, full.edge_share / 2);
  EXPECT_LE(scaledBy(0.25, full).edge_share, 0.3);
}

/// Every scaled parameter stays in its range, at both limits of the scale.
TEST(PixelScale, ScaledParametersAreLegal) {
  for (const double scale : {0.25, 4.0}) {
    Parameters params;
    params.image.search_length = 200;
    params.image.mask_dilation = 100;
    params.image.clutter_window = 16;
    params.image = scaledBy(scale, params.image);
    params.likelihood = scaledBy(scale, params.likelihood);
    EXPECT_NO_THROW(params.validate()) << scale;
  }
}

/// Largest error of the refined pose, m, from starts with 3 cm and 1 degree of error in an image of
/// this size.
double errorOfRefinement(int width, int reference_width) {
  Parameters params;
  params.image.reference_width = reference_width;
  const LocalizationMap map(test::furnishedRooms(), params);
  const CameraModel camera = test::pinhole(width, width * 3 / 4, 0.77 * width);
  const Pose truth = test::lookAlong({3.2, 2.5, 1.4}, {-1, -0.5, -0.15});
  const auto image = map.prepare(camera, test::render(map.mesh(), camera, truth, 2), {}, "room");
  RandomSource random(22);
  double sum = 0;
  constexpr int kTrials = 20;
  for (int i = 0; i < kTrials; ++i) {
    Pose start = truth;
    start.translation() += 0.03 * random.direction();
    start.linear() = start.linear() * expSo3(M_PI / 180 * random.direction());
    const RefinementResult r = map.refine({{image, Pose::Identity()}}, start, std::nullopt);
    sum += (r.pose.translation() - truth.translation()).norm() / kTrials;
  }
  return sum;
}

/// Edges are located to a part of a pixel, so half the width costs at most twice the accuracy. With
/// lengths for 640 pixels it costs more.
TEST(PixelScale, SmallImagesLoseNoMoreAccuracyThanPixels) {
  const double full = errorOfRefinement(640, 640), half = errorOfRefinement(320, 640);
  EXPECT_LT(half, 2 * full + 0.001) << "full " << full;
  EXPECT_LT(half, errorOfRefinement(320, 0));
}

}  // namespace
}  // namespace edge_mcl
