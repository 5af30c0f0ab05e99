#include "edge_mcl/localization/search/image_contours.h"

#include <gtest/gtest.h>

#include "edge_mcl/core/edges/edge_model.h"
#include "edge_mcl/core/edges/visibility.h"
#include "support/scenes.h"

namespace edge_mcl {
namespace {

/// The model is a square of 1 m, as four lines, 2 m in front of a camera that looks along z. The
/// picture shows it as a bright square of 125 pixels.
class Square : public testing::Test {
 protected:
  static MeshModel linesOf(int copies) {
    MeshSoup soup;
    for (int c = 0; c < copies; ++c) {
      const auto first = static_cast<uint32_t>(soup.vertices.size());
      // The copies lie a millimetre behind each other. So they are not welded, but they look alike
      // in the image.
      const float z = 2 + 0.001F * static_cast<float>(c);
      soup.vertices.insert(
          soup.vertices.end(),
          {{-0.5F, -0.5F, z}, {0.5F, -0.5F, z}, {0.5F, 0.5F, z}, {-0.5F, 0.5F, z}});
      for (uint32_t i = 0; i < 4; ++i) soup.lines.push_back({first + i, first + (i + 1) % 4});
    }
    return weldMesh(std::move(soup), 1e-6, "square");
  }
  ContourMatch match(int copies, const Pose& pose) const { return match(contours_, copies, pose); }
  ContourMatch match(const ImageContours& contours, int copies, const Pose& pose) const {
    MeshModel mesh = linesOf(copies);
    const EdgeModel edges = buildEdgeModel(&mesh, {});
    const Visibility visibility(mesh, edges, {});
    return contours.compare(visibility.exact(pose.translation()), camera_, pose, edges.sample_step);
  }
  size_t explained(int copies, const Pose& pose) const { return match(copies, pose).explained; }
  static cv::Mat picture() {
    cv::Mat grey(240, 320, CV_8U, cv::Scalar(80));
    cv::rectangle(grey, {98, 58}, {221, 181}, cv::Scalar(180), cv::FILLED);
    cv::GaussianBlur(grey, grey, {}, 1);
    return grey;
  }
  static Pose moved(double x, double turn_deg = 0, double roll_deg = 0) {
    Pose pose = Pose::Identity();
    pose.translation().x() = x;
    pose.linear() = expSo3({0, turn_deg * M_PI / 180, 0}) * expSo3({0, 0, roll_deg * M_PI / 180});
    return pose;
  }

  static CameraModel camera() {
    CameraModel camera = test::pinhole(320, 240, 250);
    camera.fy = camera.fx;
    camera.cy = 119.5;
    return camera;
  }

  CameraModel camera_ = camera();
  ImageContours contours_{findEdges(picture(), {}, {}, "square")};
};

TEST_F(Square, IsExplainedFromWhereItWasSeen) {
  // The square has four sides of about 124 pixels.
  EXPECT_NEAR(static_cast<double>(contours_.size()), 4 * 124, 16);
  EXPECT_GT(explained(1, moved(0)), 0.98 * static_cast<double>(contours_.size()));
}

TEST_F(Square, IsHalfExplainedFromTheSide) {
  // 0.3 m are 37 pixels. The upright sides do not overlap, and the level sides overlap by 87 of 124
  // pixels.
  const double share =
      static_cast<double>(explained(1, moved(0.3))) / static_cast<double>(contours_.size());
  EXPECT_NEAR(share, 0.5 * 87 / 124, 0.04);
}

TEST_F(Square, NothingInViewExplainsNothing) {
  EXPECT_EQ(explained(1, moved(0, 180)), 0u);
  EXPECT_EQ(explained(1, moved(0, 80)), 0u);
}

TEST_F(Square, LinesUponEachOtherCountOnce) {
  EXPECT_EQ(explained(5, moved(0)), explained(1, moved(0)));
}

TEST_F(Square, DirectionsMustAgree) {
  // The camera is turned by 45 degrees about the line of sight, so model lines only cross the
  // contours.
  EXPECT_LT(static_cast<double>(explained(1, moved(0, 0, 45))),
            0.1 * static_cast<double>(contours_.size()));
}

TEST_F(Square, NothingIsMissingFromWhereItWasSeen) {
  // Model edges may be missing at the four corners only, where the gradient of an image has no
  // direction.
  EXPECT_LE(match(1, moved(0)).missing, 16u);
  EXPECT_EQ(match(5, moved(0)).missing, match(1, moved(0)).missing);
}

TEST_F(Square, WhatTheImageDoesNotShowIsMissing) {
  // From 0.3 m to the side, the image does not show both upright sides (124 pixels each) and 37
  // pixels of both level sides. Neighbouring cells count as near, which gives back three cells of
  // two pixels at their ends.
  EXPECT_NEAR(static_cast<double>(match(1, moved(0.3)).missing), 2 * 124 + 2 * 37, 24);
  EXPECT_EQ(match(5, moved(0.3)).missing, match(1, moved(0.3)).missing);
  EXPECT_EQ(match(1, moved(0, 180)).missing, 0u);
  // On a bare wall all four sides are missing.
  const ImageContours bare(findEdges(cv::Mat(240, 320, CV_8U, cv::Scalar(90)), {}, {}, "bare"));
  EXPECT_NEAR(static_cast<double>(match(bare, 1, moved(0)).missing), 4 * 124, 16);
  EXPECT_EQ(match(bare, 1, moved(0)).explained, 0u);
}

TEST_F(Square, NothingIsMissingUnderTheMask) {
  const cv::Mat bare(240, 320, CV_8U, cv::Scalar(90));
  cv::Mat mask(240, 320, CV_8U, cv::Scalar(0));
  mask.colRange(0, 160) = 255;
  const ImageContours masked(findEdges(bare, mask, {}, "masked"));
  // In the right half, one side and half of two sides are missing.
  EXPECT_NEAR(static_cast<double>(match(masked, 1, moved(0)).missing), 2 * 124, 20);
}

TEST(ImageContours, NoiseIsNotOfAnything) {
  cv::Mat noise(240, 320, CV_8U);
  cv::RNG random(7);
  random.fill(noise, cv::RNG::NORMAL, 120, 4);
  const EdgeImage edges = findEdges(noise, {}, {}, "noise");
  EXPECT_LE(ImageContours(edges).size(), edges.edgeCount() / 10);
  EXPECT_EQ(
      ImageContours(findEdges(cv::Mat(240, 320, CV_8U, cv::Scalar(90)), {}, {}, "even")).size(),
      0u);
}

}  // namespace
}  // namespace edge_mcl
