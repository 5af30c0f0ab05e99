// Compares the window with the headless picture. Needs a display.
#include "edge_mcl/viewer/window/viewer_window.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/viewer/output/headless_view.h"
#include "support/view_scenes.h"

namespace edge_mcl {
namespace {

class OneMoment : public ViewSource {
 public:
  explicit OneMoment(const ViewMoment& moment) : moment_(moment) { history_.add(moment); }
  bool poll(ViewMoment* moment, HistoryView* history, double seconds) override {
    *moment = moment_;
    *history = history_.view(1, seconds);
    return true;
  }
  void setPose(const PoseGaussian&) override {}
  std::optional<Timeline> timeline() const override { return Timeline{0, 1, 1, false}; }
  HistoryView historyView(double seconds) const { return history_.view(1, seconds); }

 private:
  ViewMoment moment_;
  ViewHistory history_;
};

double meanDifference(const cv::Mat& a, const cv::Mat& b) {
  cv::Mat difference;
  cv::absdiff(a, b, difference);
  const cv::Scalar mean = cv::mean(difference);
  return (mean[0] + mean[1] + mean[2]) / 3;
}

TEST(ViewerWindow, ShowsWhatTheHeadlessPictureShows) {
  if (std::getenv("DISPLAY") == nullptr) GTEST_SKIP() << "SKIPPED: no display";
  const test::SimulatedMoment scene;
  const ViewParameters params;
  OneMoment source(scene.moment);
  const std::string file =
      (std::filesystem::temp_directory_path() / ("window_" + std::to_string(getpid()) + ".png"))
          .string();
  WindowReport report;
  {
    ViewerWindow window(scene.map.get(), params, &source, "test");
    const auto begin = std::chrono::steady_clock::now();
    report = window.run(
        [&] { return std::chrono::steady_clock::now() - begin < std::chrono::seconds(3); }, file);
  }
  EXPECT_GT(report.frames, 3u);
  const cv::Mat shown = cv::imread(file);
  std::filesystem::remove(file);
  ASSERT_EQ(shown.size(), cv::Size(params.width, params.height));
  HeadlessView headless(scene.map.get(), params);
  const cv::Mat drawn = headless.draw(scene.moment, source.historyView(params.strip_seconds));
  const ViewLayout layout = layoutOf(shown.size(), scene.moment.image.size());
  // The graphics card draws panels as textures. So they are nearly equal, unless they lie
  // elsewhere. A picture that is flipped must differ more.
  for (const cv::Rect& panel : {layout.edges, layout.masks, layout.strips, layout.legend}) {
    EXPECT_LT(meanDifference(shown(panel), drawn(panel)), 6) << panel;
    const cv::Mat flipped = [&] {
      cv::Mat f;
      cv::flip(shown(panel), f, 0);
      return f;
    }();
    EXPECT_GT(meanDifference(flipped, drawn(panel)),
              2 * meanDifference(shown(panel), drawn(panel)));
  }
  EXPECT_LT(meanDifference(shown(layout.space), drawn(layout.space)), 6);
}

TEST(ViewerWindow, SaysThatThereIsNoDisplay) {
  const char* display = std::getenv("DISPLAY");
  const std::string kept = display ? display : "";
  unsetenv("DISPLAY");
  unsetenv("WAYLAND_DISPLAY");
  const ViewMoment moment;
  OneMoment source(moment);
  try {
    ViewerWindow window(nullptr, ViewParameters(), &source, "test");
    ADD_FAILURE() << "a window without a display";
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("--headless"), std::string::npos);
  }
  if (display) setenv("DISPLAY", kept.c_str(), 1);
}

}  // namespace
}  // namespace edge_mcl
