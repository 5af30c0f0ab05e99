// Tests the picture of the viewer: things must be drawn in their places, and the picture must be
// drawn even when some of its data are missing.
#include "edge_mcl/viewer/output/headless_view.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <opencv2/imgproc.hpp>
#include <set>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/drawing/overlay.h"
#include "edge_mcl/viewer/drawing/view_colors.h"
#include "support/scenes.h"
#include "support/view_scenes.h"

namespace edge_mcl {
namespace {

class HeadlessPicture : public testing::Test {
 protected:
  cv::Mat draw(const ViewMoment& moment) {
    HeadlessView view(scene_.map.get(), params_);
    ViewHistory history;
    for (int i = 0; i < 20; ++i) {
      ViewMoment before = moment;
      before.time -= 0.1 * (20 - i);
      history.add(before);
    }
    history.add(moment);
    cv::Mat picture = view.draw(moment, history.view(history.size(), params_.strip_seconds));
    camera_ = view.space().camera();
    return picture;
  }

  /// Projects a point into the picture of space. It uses only the angles of the camera, so it is
  /// independent of the viewer. @return pixel
  cv::Point inSpace(const Eigen::Vector3d& point, const cv::Size& size) const {
    const double azimuth = static_cast<double>(camera_.getAzimuthDegrees()) * M_PI / 180;
    const double elevation = static_cast<double>(camera_.getElevationDegrees()) * M_PI / 180;
    const Eigen::Vector3d focus(static_cast<double>(camera_.getPointingAtX()),
                                static_cast<double>(camera_.getPointingAtY()),
                                static_cast<double>(camera_.getPointingAtZ()));
    const Eigen::Vector3d back(std::cos(azimuth) * std::cos(elevation),
                               std::sin(azimuth) * std::cos(elevation), std::sin(elevation));
    const Eigen::Vector3d eye = focus + static_cast<double>(camera_.getZoomDistance()) * back;
    const Pose look = test::lookAlong(eye, -back);
    const Eigen::Vector3d p = look.inverse() * point;
    const double focal = size.height / 2.0 / std::tan(SceneView::kFieldOfViewDeg * M_PI / 360);
    return {cvRound(size.width / 2.0 + focal * p.x() / p.z()),
            cvRound(size.height / 2.0 + focal * p.y() / p.z())};
  }

  test::SimulatedMoment scene_;
  ViewParameters params_;
  mrpt::opengl::CCamera camera_;
};

/// The truth is the projection of the visible samples by the camera model.
TEST_F(HeadlessPicture, ModelEdgesLieOnTheProjectedModel) {
  const ViewMoment& m = scene_.moment;
  const cv::Mat picture = draw(m);
  ASSERT_EQ(picture.size(), cv::Size(1280, 720));
  const ViewLayout layout = layoutOf(picture.size(), m.image.size());
  const cv::Mat panel = picture(layout.edges);
  const PanelFit fit = fitImage(m.image.size(), layout.edges.size());
  const Pose to_camera = m.estimate.mean.inverse();
  const VisibleSet visible = scene_.map->visibility().exact(m.estimate.mean.translation());
  int samples = 0, drawn = 0;
  cv::Mat near_model(panel.size(), CV_8U, cv::Scalar(0));
  for (const VisibleSet::Segment& segment : visible.segments)
    for (uint32_t i = 0; i < EdgeSegment::kMaxSamples; ++i) {
      if (!(segment.samples >> i & 1u)) continue;
      Eigen::Vector2d pixel;
      const Eigen::Vector3d p =
          to_camera * scene_.map->edges().samplePosition(visible.edgeSegment(segment), i);
      if (!m.camera.project(p, &pixel) || !m.camera.contains(pixel)) continue;
      const cv::Point at(fit.area.x + cvRound((pixel.x() + 0.5) * fit.scale - 0.5),
                         fit.area.y + cvRound((pixel.y() + 0.5) * fit.scale - 0.5));
      // A sample covers half a step to either side. Pixels this near may be green, too.
      cv::circle(near_model, at, 14, cv::Scalar(255), cv::FILLED);
      constexpr int kMargin = 30;  // space for titles and the border of the image
      if (at.y < kMargin || at.x < kMargin || at.x > panel.cols - kMargin ||
          at.y > panel.rows - kMargin)
        continue;
      ++samples;
      drawn += test::hasColorNear(panel, at, {60, 200, 30}, 2, 90) ? 1 : 0;
    }
  ASSERT_GT(samples, 100);
  // Red normals and neighbouring lines cover a few samples.
  EXPECT_GT(drawn, 0.95 * samples);
  // Elsewhere hardly anything may be green.
  int green = 0, astray = 0;
  for (int y = 30; y < panel.rows; ++y)
    for (int x = 0; x < panel.cols; ++x)
      if (test::hasColorNear(panel, {x, y}, {60, 200, 30}, 0, 40)) {
        ++green;
        astray += near_model.at<uint8_t>(y, x) == 0 ? 1 : 0;
      }
  EXPECT_GT(green, 300);
  EXPECT_LT(astray, 0.02 * green);
}

/// The truth is inSpace().
TEST_F(HeadlessPicture, TheCameraIsWhereItIsInSpace) {
  ViewMoment m = scene_.moment;
  m.truth.reset();
  const cv::Mat picture = draw(m);
  const ViewLayout layout = layoutOf(picture.size(), m.image.size());
  const cv::Mat space = picture(layout.space);
  const Eigen::Vector3d eye = m.estimate.mean.translation();
  EXPECT_TRUE(test::hasColorNear(space, inSpace(eye, space.size()), view_colors::kEstimate, 3, 60));
  // These points lie on the lines of the view, half-way to the corners of its picture.
  int seen = 0;
  for (const double u : {0.0, static_cast<double>(m.camera.width)})
    for (const double v : {0.0, static_cast<double>(m.camera.height)}) {
      const Eigen::Vector3d corner = test::plainRay(m.camera, u, v);
      const double depth = 0.04 * static_cast<double>(camera_.getZoomDistance());
      const cv::Point at = inSpace(m.estimate.mean * (depth * corner), space.size());
      seen += test::hasColorNear(space, at, view_colors::kEstimate, 3, 60) ? 1 : 0;
    }
  EXPECT_GE(seen, 3) << "of four; one may be behind the picture";
  std::set<int> colors;
  for (int y = 0; y < space.rows; y += 4)
    for (int x = 0; x < space.cols; x += 4) {
      const cv::Vec3b& p = space.at<cv::Vec3b>(y, x);
      colors.insert(p[0] << 16 | p[1] << 8 | p[2]);
    }
  EXPECT_GT(colors.size(), 20u) << "a model is more than its background";
}

TEST_F(HeadlessPicture, StateAndMaskAreShown) {
  ViewMoment m = scene_.moment;
  m.state = LocalizerState::kLost;
  m.mask = cv::Mat(m.image.size(), CV_8U, cv::Scalar(0));
  const cv::Rect object(m.image.cols / 2, m.image.rows / 2, m.image.cols / 4, m.image.rows / 4);
  m.mask(object).setTo(255);
  const cv::Mat picture = draw(m);
  const ViewLayout layout = layoutOf(picture.size(), m.image.size());
  const cv::Mat strips = picture(layout.strips);
  EXPECT_TRUE(test::hasColorNear(strips, {strips.cols - 20, 31},
                                 view_colors::ofState(LocalizerState::kLost), 2, 30));
  const cv::Mat masks = picture(layout.masks);
  const PanelFit fit = fitImage(m.image.size(), layout.masks.size());
  const cv::Mat plain = m.image;
  const auto shown = [&](cv::Point at) {
    return masks.at<cv::Vec3b>(fit.area.y + cvRound(at.y * fit.scale),
                               fit.area.x + cvRound(at.x * fit.scale));
  };
  const cv::Point inside(object.x + object.width / 2, object.y + object.height / 2);
  const cv::Point outside(object.x / 2, object.y / 2 + 20);
  const auto change = [&](cv::Point at) {
    const cv::Vec3b a = shown(at);
    const cv::Vec3b& b = plain.at<cv::Vec3b>(at);
    return std::abs(a[0] - b[0]) + std::abs(a[1] - b[1]) + std::abs(a[2] - b[2]);
  };
  EXPECT_GT(change(inside), 40);
  EXPECT_LT(change(outside), 30);
}

TEST_F(HeadlessPicture, IsDrawnWhateverIsMissing) {
  const auto looksRight = [&](const ViewMoment& moment) {
    const cv::Mat picture = draw(moment);
    return picture.size() == cv::Size(1280, 720) &&
           cv::countNonZero(cv::Mat(picture.reshape(1) != 0)) > 100000;
  };
  EXPECT_TRUE(looksRight(ViewMoment()));
  ViewMoment m = scene_.moment;
  m.image.release();
  m.mask.release();
  EXPECT_TRUE(looksRight(m)) << "no image";
  m = scene_.moment;
  m.mask = cv::Mat(7, 9, CV_8U, cv::Scalar(255));
  EXPECT_TRUE(looksRight(m)) << "a mask of another size";
  m = scene_.moment;
  m.camera.width = 100;
  EXPECT_TRUE(looksRight(m)) << "a camera of another size";
  m = scene_.moment;
  m.objects = {{"person", 0.5F, 1, {-50, -50, 20, 20}}, {"chair", 2.0F, -1, {300, 200, 9e6F, 4}}};
  EXPECT_TRUE(looksRight(m)) << "boxes beyond the image";
  m.has_pose = false;
  m.clusters.push_back({scene_.moment.estimate.mean, 1});
  EXPECT_TRUE(looksRight(m)) << "searching";
  m = scene_.moment;
  m.particles.assign(3000, m.estimate.mean);
  m.weights.assign(3000, NAN);
  EXPECT_TRUE(looksRight(m)) << "weights that are no numbers";
  cv::cvtColor(scene_.moment.image, m.image, cv::COLOR_BGR2GRAY);
  EXPECT_TRUE(looksRight(m)) << "a grey image";
}

/// The colour image and its versions with alpha and with 16 bits must look alike. The grey image
/// and its version with 16 bits must look alike.
TEST_F(HeadlessPicture, ImagesOfAnyKindLookAlike) {
  cv::Mat grey, with_alpha, deep, deep_grey;
  cv::cvtColor(scene_.moment.image, grey, cv::COLOR_BGR2GRAY);
  cv::cvtColor(scene_.moment.image, with_alpha, cv::COLOR_BGR2BGRA);
  scene_.moment.image.convertTo(deep, CV_16U, 256);
  grey.convertTo(deep_grey, CV_16U, 256);
  const auto panels = [&](const cv::Mat& image, bool with_mask) {
    ViewMoment m = scene_.moment;
    m.image = image;
    m.mask.release();
    if (with_mask) m.mask = cv::Mat(image.size(), CV_8U, cv::Scalar(0));
    if (with_mask) m.mask(cv::Rect(20, 30, 100, 80)).setTo(255);
    const cv::Mat picture = draw(m);
    const ViewLayout layout = layoutOf(picture.size(), image.size());
    return picture(layout.edges | layout.masks).clone();
  };
  for (const bool with_mask : {false, true}) {
    const cv::Mat in_color = panels(scene_.moment.image, with_mask);
    const cv::Mat in_grey = panels(grey, with_mask);
    const double pixels = static_cast<double>(in_color.total());
    EXPECT_LT(cv::norm(panels(with_alpha, with_mask), in_color, cv::NORM_L1), pixels);
    EXPECT_LT(cv::norm(panels(deep, with_mask), in_color, cv::NORM_L1), pixels);
    EXPECT_LT(cv::norm(panels(deep_grey, with_mask), in_grey, cv::NORM_L1), pixels);
    // Images that the localizer does not accept must not end the viewer.
    EXPECT_NO_THROW(panels(cv::Mat(grey.size(), CV_32F, cv::Scalar(1)), with_mask));
    EXPECT_NO_THROW(panels(cv::Mat(grey.size(), CV_8UC2, cv::Scalar(1, 1)), with_mask));
  }
}

TEST_F(HeadlessPicture, ImagesMayChangeTheirSizeOrBeMissing) {
  for (const cv::Size& first : {cv::Size(1280, 720), cv::Size()}) {
    HeadlessView view(scene_.map.get(), params_);
    ViewHistory history;
    history.add(scene_.moment);
    for (const cv::Size& size :
         {first, cv::Size(), cv::Size(1280, 720), cv::Size(640, 480), cv::Size(480, 640)}) {
      ViewMoment m = scene_.moment;
      m.mask.release();
      m.image.release();
      if (!size.empty()) cv::resize(scene_.moment.image, m.image, size);
      cv::Mat picture;
      ASSERT_NO_THROW(picture = view.draw(m, history.view(1, params_.strip_seconds))) << size;
      const cv::Mat space = picture(layoutOf(picture.size(), first).space);
      cv::Scalar mean, spread;
      cv::meanStdDev(space, mean, spread);
      EXPECT_GT(spread[1], 5) << "a model is more than its background; " << size;
    }
  }
}

TEST_F(HeadlessPicture, TheModelMayComeLater) {
  HeadlessView view(nullptr, params_);
  ViewHistory history;
  history.add(scene_.moment);
  const auto space = [&] {
    const cv::Mat picture = view.draw(scene_.moment, history.view(1, params_.strip_seconds));
    return picture(layoutOf(picture.size(), scene_.moment.image.size()).space).clone();
  };
  const cv::Mat without = space();
  view.setMap(scene_.map.get());
  EXPECT_GT(cv::norm(space(), without, cv::NORM_L1), 5.0 * static_cast<double>(without.total()));
}

/// The switch model_edges removes the green model edges.
TEST_F(HeadlessPicture, SwitchesLeaveThingsOut) {
  const auto greens = [&] {
    const cv::Mat picture = draw(scene_.moment);
    const cv::Mat panel = picture(layoutOf(picture.size(), scene_.moment.image.size()).edges);
    int count = 0;
    for (int y = 30; y < panel.rows; ++y)
      for (int x = 0; x < panel.cols; ++x)
        count += test::hasColorNear(panel, {x, y}, {60, 200, 30}, 0, 40) ? 1 : 0;
    return count;
  };
  EXPECT_GT(greens(), 300);
  params_.model_edges = false;
  EXPECT_LT(greens(), 20);
}

/// Draws as on a computer without a graphics driver. Ends the process with 7 when the error is one
/// line.
void drawWithoutEgl() {
  setenv("__EGL_VENDOR_LIBRARY_DIRS", "/nonexistent", 1);
  try {
    HeadlessView(nullptr, ViewParameters()).draw(ViewMoment(), HistoryView());
  } catch (const InputError& e) {
    std::fprintf(stderr, "%s\n", e.what());
    std::exit(std::strchr(e.what(), '\n') == nullptr ? 7 : 1);
  }
  std::exit(2);
}

TEST(HeadlessViewDeathTest, SaysInOneLineThatNothingCanBeRendered) {
  // EGL searches for drivers once per process. So the test needs a new process.
  testing::FLAGS_gtest_death_test_style = "threadsafe";
  EXPECT_EXIT(drawWithoutEgl(), testing::ExitedWithCode(7), "nothing can be rendered here");
}

/// Green pixels of the overlay must be green at their place in the enlarged overlay.
TEST(Overlay, EnlargedIsTheSameAtItsPlace) {
  test::SimulatedMoment scene;
  const ViewMoment& m = scene.moment;
  const auto prepared = scene.map->prepare(m.camera, m.image, m.mask, "image");
  const cv::Mat one = drawOverlay(*scene.map, *prepared, m.estimate.mean);
  const cv::Mat three = drawOverlay(*scene.map, *prepared, m.estimate.mean, {}, 3);
  ASSERT_EQ(three.size(), one.size() * 3);
  int green = 0, found = 0;
  for (int y = 2; y < one.rows - 2; ++y)
    for (int x = 2; x < one.cols - 2; ++x) {
      if (!test::hasColorNear(one, {x, y}, {60, 200, 30}, 0, 30)) continue;
      ++green;
      found += test::hasColorNear(three, {3 * x + 1, 3 * y + 1}, {60, 200, 30}, 3, 60) ? 1 : 0;
    }
  ASSERT_GT(green, 100);
  EXPECT_GT(found, 0.97 * green);
}

}  // namespace
}  // namespace edge_mcl
