#include "edge_mcl/core/likelihood/score_table.h"

#include <gtest/gtest.h>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/base/random_source.h"
#include "edge_mcl/core/image/image_edges.h"
#include "support/error_text.h"

namespace edge_mcl {
namespace {

// The kernels address the table with offsets of 32 bits. A larger table is an error.
TEST(ScoreTable, OneThatIsTooLargeIsRefused) {
  ScoreTable::checkSize(5472, 3648, 12);
  EXPECT_THROW(ScoreTable::checkSize(5472, 3648, 64), InputError);
  EXPECT_THROW(ScoreTable::checkSize(12000, 9000, 12), InputError);
}

TEST(ScoreTable, TheErrorNamesTheParameterToReduce) {
  const std::string text =
      test::errorText<InputError>([] { ScoreTable::checkSize(5472, 3648, 64); });
  EXPECT_TRUE(test::contains(text, "5472x3648")) << text;
  EXPECT_TRUE(test::contains(text, "image.orientation_bins")) << text;
}

/// An image with edges at random pixels and of random directions.
EdgeImage randomEdges(int width, int height, bool with_mask) {
  RandomSource random(5);
  EdgeImage image;
  image.grey = cv::Mat(height, width, CV_8U, cv::Scalar(0));
  image.edges = cv::Mat(height, width, CV_8U, cv::Scalar(0));
  image.gradient_x = cv::Mat(height, width, CV_16S);
  image.gradient_y = cv::Mat(height, width, CV_16S);
  if (with_mask) image.ignore = cv::Mat(height, width, CV_8U, cv::Scalar(0));
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      image.edges.at<uint8_t>(y, x) = random.uniform() < 0.1 ? 255 : 0;
      image.gradient_x.at<int16_t>(y, x) = static_cast<int16_t>(1000 * random.normal());
      image.gradient_y.at<int16_t>(y, x) = static_cast<int16_t>(1000 * random.normal());
      if (with_mask) image.ignore.at<uint8_t>(y, x) = random.uniform() < 0.2 ? 255 : 0;
    }
  return image;
}

class ScoreTableOfEdges : public testing::TestWithParam<std::tuple<int, bool, LikelihoodModel>> {};

/// The truth looks up every pixel alone: the byte that belongs to the number of steps, at the
/// density of clutter there, or 0 where the pixel is ignored. Widths that are no multiple of eight
/// are tried, because the table is made from eight pixels at a time. The search lengths 24 and 60
/// have tables of fewer and of more than 32 entries.
TEST_P(ScoreTableOfEdges, HoldsTheByteOfEveryPixel) {
  const auto [width, with_mask, model] = GetParam();
  constexpr int kHeight = 45;
  LikelihoodParameters likelihood;
  likelihood.model = model;
  for (const int search_length : {24, 60}) {
    ImageParameters params;
    params.search_length = search_length;
    params.orientation_bins = 6;
    const EdgeImage image = randomEdges(width, kHeight, with_mask);
    const EdgeField field(image, EdgePixels(image), params);
    const ScoreLevels levels(params, likelihood);
    const ScoreTable table(field, levels);
    EXPECT_EQ(table.width(), width);
    EXPECT_EQ(table.height(), kHeight);
    EXPECT_EQ(table.bins(), 6);
    EXPECT_EQ(table.hasIgnored(), with_mask);
    EXPECT_EQ(table.scale(), levels.scale());
    EXPECT_EQ(table.offset(), levels.offset());
    for (int bin = 0; bin < 6; ++bin)
      for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < width; ++x) {
          const auto clutter = static_cast<float>(field.clutter(bin, x, y));
          const uint8_t steps = field.steps(bin)[y * field.stepsStride() + x];
          const bool ignored = with_mask && image.ignore.at<uint8_t>(y, x) != 0;
          ASSERT_EQ(int{table.code(bin, x, y)},
                    ignored ? 0 : int{levels.codes(bin, clutter)[steps]})
              << "bin " << bin << ", pixel " << x << ", " << y;
        }
  }
}

/// The high byte of an element is the low byte of the same pixel in the next direction. After the
/// last direction comes the first one, because directions are those of undirected lines.
TEST_P(ScoreTableOfEdges, StoresTheNextDirectionBeside) {
  const auto [width, with_mask, model] = GetParam();
  LikelihoodParameters likelihood;
  likelihood.model = model;
  ImageParameters params;
  params.orientation_bins = 5;
  const EdgeImage image = randomEdges(width, 20, with_mask);
  const ScoreTable table(EdgeField(image, EdgePixels(image), params),
                         ScoreLevels(params, likelihood));
  ASSERT_GE(table.pairCount(), static_cast<size_t>(5 * table.rows() * table.stride()));
  for (int bin = 0; bin < 5; ++bin)
    for (int y = 0; y < table.rows(); ++y)
      for (int x = 0; x < table.stride(); ++x) {
        const auto pairAt = [&, row = y, column = x](int b) {
          return table.pairs()[(b * table.rows() + row) * table.stride() + column];
        };
        ASSERT_EQ(pairAt(bin) >> 8, pairAt((bin + 1) % 5) & 0xff);
      }
}

/// A kernel that interpolates at the last column or row reads the column or row behind it, with
/// the weight 0. There it must find a score where the image has one, and 0 at ignored pixels only.
TEST_P(ScoreTableOfEdges, TheBorderIsRepeatedOnce) {
  const auto [width, with_mask, model] = GetParam();
  LikelihoodParameters likelihood;
  likelihood.model = model;
  ImageParameters params;
  params.orientation_bins = 4;
  const EdgeImage image = randomEdges(width, 20, with_mask);
  const ScoreTable table(EdgeField(image, EdgePixels(image), params),
                         ScoreLevels(params, likelihood));
  ASSERT_EQ(table.stride(), width + 1);
  ASSERT_EQ(table.rows(), 21);
  for (int bin = 0; bin < 4; ++bin) {
    for (int y = 0; y < 20; ++y)
      EXPECT_EQ(table.code(bin, width, y), table.code(bin, width - 1, y));
    for (int x = 0; x <= width; ++x) EXPECT_EQ(table.code(bin, x, 20), table.code(bin, x, 19));
  }
}

INSTANTIATE_TEST_SUITE_P(All, ScoreTableOfEdges,
                         testing::Combine(testing::Values(1, 40, 61, 67), testing::Bool(),
                                          testing::Values(LikelihoodModel::kPaper,
                                                          LikelihoodModel::kRobust)));

}  // namespace
}  // namespace edge_mcl
