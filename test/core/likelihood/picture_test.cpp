#include "edge_mcl/core/likelihood/picture.h"

#include <gtest/gtest.h>

#include <thread>
#include <vector>

#include "edge_mcl/core/image/edge_field.h"
#include "edge_mcl/core/image/image_edges.h"
#include "support/room_view.h"

namespace edge_mcl {
namespace {

class PictureOfARoom : public testing::Test {
 protected:
  cv::Mat ignored() const {
    cv::Mat mask(240, 320, CV_8U, cv::Scalar(0));
    mask(cv::Rect(100, 80, 60, 50)).setTo(255);
    return mask;
  }

  const ImageParameters params_{};
  const std::shared_ptr<const ScoreLevels> levels_ =
      std::make_shared<ScoreLevels>(params_, LikelihoodParameters());
};

TEST_F(PictureOfARoom, KeepsWhatItIsMadeFrom) {
  const cv::Mat grey = test::roomPicture(), mask = ignored();
  const Picture picture(grey, mask, params_, levels_);
  EXPECT_EQ(picture.grey().data, grey.data);
  EXPECT_EQ(picture.ignore().data, mask.data);
  EXPECT_EQ(picture.levels(), levels_);
  EXPECT_EQ(picture.params().search_length, params_.search_length);
}

/// The truth is the table that is made step by step: edges, field, table.
TEST_F(PictureOfARoom, ItsTableIsTheOneMadeStepByStep) {
  for (const cv::Mat& mask : {cv::Mat(), ignored()}) {
    const Picture picture(test::roomPicture(), mask, params_, levels_);
    const EdgeImage edges = findEdgesOf(test::roomPicture(), mask, params_);
    const ScoreTable expected(EdgeField(edges, EdgePixels(edges), params_), *levels_);
    const std::shared_ptr<const ScoreTable> table = picture.table();
    ASSERT_NE(table, nullptr);
    EXPECT_EQ(table->hasIgnored(), !mask.empty());
    ASSERT_EQ(table->pairCount(), expected.pairCount());
    EXPECT_TRUE(
        std::equal(expected.pairs(), expected.pairs() + expected.pairCount(), table->pairs()));
  }
}

/// Many threads that ask at once get one table.
TEST_F(PictureOfARoom, TheTableIsMadeOnce) {
  const Picture picture(test::roomPicture(), {}, params_, levels_);
  std::vector<std::shared_ptr<const ScoreTable>> tables(8);
  std::vector<std::thread> threads;
  threads.reserve(tables.size());
  for (auto& table : tables) threads.emplace_back([&] { table = picture.table(); });
  for (auto& thread : threads) thread.join();
  for (const auto& table : tables) EXPECT_EQ(table, picture.table());
}

}  // namespace
}  // namespace edge_mcl
