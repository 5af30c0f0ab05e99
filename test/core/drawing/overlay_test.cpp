#include "edge_mcl/core/drawing/overlay.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "support/painted.h"
#include "support/room_view.h"

namespace edge_mcl {
namespace {

const cv::Scalar kBlue(255, 120, 30);

/// 255 where one channel exceeds both others: 1 green, 2 red. The grey picture has no such pixels.
cv::Mat pixelsOfHue(const cv::Mat& picture, int channel) {
  constexpr int kMore = 40;  // lines are smoothed, so their colour is blended with the grey
  cv::Mat pixels(picture.size(), CV_8U, cv::Scalar(0));
  for (int y = 0; y < picture.rows; ++y)
    for (int x = 0; x < picture.cols; ++x) {
      const auto& p = picture.at<cv::Vec3b>(y, x);
      if (p[channel] > p[(channel + 1) % 3] + kMore && p[channel] > p[(channel + 2) % 3] + kMore)
        pixels.at<uint8_t>(y, x) = 255;
    }
  return pixels;
}
constexpr int kGreenHue = 1, kRedHue = 2;

class Overlay : public testing::Test {
 protected:
  std::shared_ptr<const PreparedImage> prepare(const cv::Mat& mask = {}) const {
    return map_.prepare(test::roomCamera(), test::roomPicture(), mask, "room");
  }
  /// Pixels of the visible samples that are inside the image.
  std::vector<Eigen::Vector2d> samplesAt(const Pose& pose) const {
    std::vector<Eigen::Vector2d> pixels;
    const VisibleSet set = map_.visibility().exact(pose.translation());
    for (const VisibleSet::Segment& s : set.segments)
      for (uint32_t i = 0; i < EdgeSegment::kMaxSamples; ++i) {
        Eigen::Vector2d pixel;
        if ((s.samples >> i & 1u) &&
            camera_.project(pose.inverse() * map_.edges().samplePosition(set.edgeSegment(s), i),
                            &pixel) &&
            camera_.contains(pixel))
          pixels.push_back(pixel);
      }
    return pixels;
  }

  const LocalizationMap map_{test::furnishedRooms(), Parameters()};
  const CameraModel camera_ = test::roomCamera();
  static constexpr OverlayParts kNothing{false, false, false, false};
};

/// The image is dimmed to 0.6 of its grey level plus 50, so that colours stand out.
TEST_F(Overlay, WithoutPartsIsTheDimmedImage) {
  const cv::Mat picture = drawOverlay(map_, *prepare(), test::roomView(), kNothing);
  ASSERT_EQ(picture.type(), CV_8UC3);
  ASSERT_EQ(picture.size(), cv::Size(320, 240));
  for (int y = 0; y < 240; y += 7)
    for (int x = 0; x < 320; x += 7)
      for (int c = 0; c < 3; ++c)
        ASSERT_NEAR(picture.at<cv::Vec3b>(y, x)[c],
                    50 + 0.6 * test::roomPicture().at<uint8_t>(y, x), 1);
}

TEST_F(Overlay, IsEnlargedByItsScale) {
  EXPECT_EQ(drawOverlay(map_, *prepare(), test::roomView(), {}, 2).size(), cv::Size(640, 480));
  EXPECT_EQ(drawOverlay(map_, *prepare(), test::roomView(), {}, 0.5).size(), cv::Size(160, 120));
}

TEST_F(Overlay, ImageEdgesAreBlue) {
  const auto image = prepare();
  OverlayParts parts = kNothing;
  parts.image_edges = true;
  const cv::Mat picture = drawOverlay(map_, *image, test::roomView(), parts);
  EXPECT_EQ(cv::norm(test::pixelsOf(picture, kBlue), image->edges.edges, cv::NORM_INF), 0);
}

/// The mask makes pixels purple: more blue and red, the same green.
TEST_F(Overlay, TheMaskIsShaded) {
  cv::Mat mask(240, 320, CV_8U, cv::Scalar(0));
  mask(cv::Rect(100, 80, 60, 50)).setTo(255);
  const auto image = prepare(mask);
  OverlayParts parts = kNothing;
  parts.mask = true;
  const cv::Mat shaded = drawOverlay(map_, *image, test::roomView(), parts);
  const cv::Mat plain = drawOverlay(map_, *image, test::roomView(), kNothing);
  for (int y = 0; y < 240; y += 3)
    for (int x = 0; x < 320; x += 3) {
      const bool ignored = image->edges.ignore.at<uint8_t>(y, x) != 0;
      const auto &a = shaded.at<cv::Vec3b>(y, x), &b = plain.at<cv::Vec3b>(y, x);
      ASSERT_EQ(a[1], b[1]);
      ASSERT_EQ(a[0] > b[0] && a[2] > b[2], ignored);
    }
}

/// The truth are the projected samples of the model. Every sample must be green within a pixel, and
/// every green pixel must have a sample within 8 px, as neighbouring samples are up to 8 px apart.
/// Samples at the border are not checked, because a piece of line that leaves the image is left
/// out. At the scale 3 the centre of the pixel (u, v) is at 3 u + 1.
TEST_F(Overlay, ModelEdgesAreGreenWhereTheModelIsProjected) {
  OverlayParts parts = kNothing;
  parts.model_edges = true;
  for (const Pose& pose : {test::roomView(), test::lookAlong({6, 2.5, 1.2}, {1, 0.3, 0})})
    for (const double scale : {1.0, 3.0}) {
      const cv::Mat green =
          pixelsOfHue(drawOverlay(map_, *prepare(), pose, parts, scale), kGreenHue);
      cv::Mat expected(green.size(), CV_8U, cv::Scalar(0));
      size_t found = 0, checked = 0;
      for (const Eigen::Vector2d& pixel : samplesAt(pose)) {
        const cv::Point at(static_cast<int>(std::lround(scale * pixel.x() + (scale - 1) / 2)),
                           static_cast<int>(std::lround(scale * pixel.y() + (scale - 1) / 2)));
        cv::circle(expected, at, static_cast<int>(8 * scale), cv::Scalar(255), cv::FILLED);
        const cv::Rect around(at.x - 1, at.y - 1, 3, 3);
        if (pixel.x() < 10 || pixel.y() < 10 || pixel.x() > 309 || pixel.y() > 229) continue;
        ++checked;
        found += cv::countNonZero(green(around)) > 0;
      }
      ASSERT_GT(checked, 40u);
      EXPECT_EQ(found, checked);
      EXPECT_EQ(cv::countNonZero(green & ~expected), 0);
    }
}

/// At the true pose model and image edges lie on each other, so there are nearly no normals between
/// them. With the camera moved aside by 10 cm there are many.
TEST_F(Overlay, NormalsAreRedBetweenModelAndImageEdges) {
  OverlayParts parts = kNothing;
  parts.normals = true;
  const auto redAt = [&](const Pose& pose) {
    return cv::countNonZero(pixelsOfHue(drawOverlay(map_, *prepare(), pose, parts, 2), kRedHue));
  };
  Pose aside = test::roomView();
  aside.translation() += 0.1 * aside.linear().col(0);
  EXPECT_GT(redAt(aside), 300);
  EXPECT_LT(redAt(test::roomView()), redAt(aside) / 4);
  parts.normals = false;
  parts.model_edges = true;
  EXPECT_EQ(redAt(aside), 0);
}

TEST_F(Overlay, HasAllPartsByDefault) {
  Pose aside = test::roomView();
  aside.translation() += 0.1 * aside.linear().col(0);
  const cv::Mat picture = drawOverlay(map_, *prepare(), aside);
  EXPECT_GT(cv::countNonZero(test::pixelsOf(picture, kBlue)), 100);
  EXPECT_GT(cv::countNonZero(pixelsOfHue(picture, kGreenHue)), 100);
  EXPECT_GT(cv::countNonZero(pixelsOfHue(picture, kRedHue)), 100);
}

const cv::Scalar kCrease(178, 114, 0), kBoundary(0, 94, 213), kContour(0, 159, 230);

/// The part of a wireframe without the legend and the size.
cv::Mat modelPart(const cv::Mat& picture) {
  cv::Mat part = picture.clone();
  part(cv::Rect(0, 0, 160, 120)).setTo(cv::Scalar::all(255));
  part.rowRange(part.rows - 30, part.rows).setTo(cv::Scalar::all(255));
  return part;
}

/// Boxes of different shapes, in pictures of different shapes: nothing touches the border.
TEST(Wireframe, ShowsTheWholeModel) {
  for (const Eigen::Vector3f& high :
       {Eigen::Vector3f(1, 1, 1), Eigen::Vector3f(20, 1, 1), Eigen::Vector3f(1, 1, 20)})
    for (const cv::Size& size : {cv::Size(640, 480), cv::Size(480, 640)}) {
      MeshSoup soup;
      test::addBox(&soup, {0, 0, 0}, high);
      const LocalizationMap map(weldMesh(soup, 1e-6, "box"), Parameters());
      const cv::Mat picture = drawWireframe(map, size.width, size.height);
      ASSERT_EQ(picture.size(), size);
      ASSERT_EQ(picture.type(), CV_8UC3);
      const cv::Rect model = test::bounds(test::paintedPixels(modelPart(picture)));
      EXPECT_GT(model.area(), 1000);
      EXPECT_GT(model.x, 0);
      EXPECT_GT(model.y, 0);
      EXPECT_LT(model.br().x, size.width);
      EXPECT_LT(model.br().y, size.height);
    }
}

/// A closed box has creases only, a single triangle has boundaries only. The colour also appears in
/// the legend.
TEST(Wireframe, KindsHaveTheirColours) {
  MeshSoup box, sheet;
  test::addBox(&box, {0, 0, 0}, {1, 1, 1});
  sheet.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  sheet.triangles = {{0, 1, 2}};
  sheet.triangle_material = {0};
  const cv::Rect legend(0, 0, 160, 120);
  for (const bool closed : {true, false}) {
    const LocalizationMap map(weldMesh(closed ? box : sheet, 1e-6, "model"), Parameters());
    const cv::Mat picture = drawWireframe(map, 640, 480), model = modelPart(picture);
    const auto count = [](const cv::Mat& part, const cv::Scalar& colour) {
      return cv::countNonZero(test::pixelsOf(part, colour, 30));
    };
    EXPECT_GT(count(model, closed ? kCrease : kBoundary), 20);
    EXPECT_EQ(count(model, closed ? kBoundary : kCrease), 0);
    EXPECT_GT(count(picture(legend), closed ? kCrease : kBoundary), 20);
    EXPECT_EQ(count(picture(legend), closed ? kBoundary : kCrease), 0);
  }
}

/// Of a column with forty sides two outlines are visible from any viewpoint beside it. Their pixels
/// are two connected regions.
TEST(Wireframe, OfAColumnTwoContoursAreDrawn) {
  const LocalizationMap map(test::column(40, 0.5f, 2), Parameters());
  ASSERT_EQ(map.edges().countOf(EdgeKind::kContour), 40u);
  cv::Mat contours = test::pixelsOf(modelPart(drawWireframe(map, 640, 480)), kContour, 60);
  cv::dilate(contours, contours, cv::Mat::ones(5, 5, CV_8U));
  cv::Mat labels;
  EXPECT_EQ(cv::connectedComponents(contours, labels) - 1, 2);
  const cv::Rect all = test::bounds(contours);
  EXPECT_GT(all.height, 50);
  EXPECT_GT(all.width, 20);
}

}  // namespace
}  // namespace edge_mcl
