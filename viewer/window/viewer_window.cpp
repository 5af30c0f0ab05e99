#include "edge_mcl/viewer/window/viewer_window.h"

#include <mrpt/gui/CDisplayWindowGUI.h>
#include <mrpt/math/TLine3D.h>
#include <mrpt/opengl/COpenGLScene.h>

#include <chrono>
#include <cstdio>
#include <filesystem>
#include <opencv2/imgproc.hpp>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/image/picture_file.h"
#include "edge_mcl/viewer/drawing/panels.h"
#include "edge_mcl/viewer/drawing/view_layout.h"
#include "edge_mcl/viewer/output/video_file.h"
#include "edge_mcl/viewer/scene/pose_pick.h"
#include "edge_mcl/viewer/scene/scene_view.h"
#include "edge_mcl/viewer/window/blitted_picture.h"
#include "edge_mcl/viewer/window/window_controls.h"

namespace edge_mcl {

namespace {

double wallClock() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// Returns the first unused name of edge_mcl-1.png, edge_mcl-2.png and so on.
std::string freeName(const std::string& ending) {
  for (int k = 1;; ++k) {
    std::string name = "edge_mcl-" + std::to_string(k) + ending;
    if (!std::filesystem::exists(name)) return name;
  }
}

constexpr double kVideoRate = 25;

}  // namespace

/// MRPT's window. The 3D scene fills a part of it, pictures fill the rest.
class ViewerWindow::Window : public mrpt::gui::CDisplayWindowGUI {
 public:
  Window(const LocalizationMap* map, const ViewParameters& params, ViewSource* source,
         const std::string& title)
      : CDisplayWindowGUI(title, static_cast<unsigned>(params.width),
                          static_cast<unsigned>(params.height)),
        map_(map),
        params_(params),
        source_(source),
        space_(map, params),
        controls_(this, source, &params_, &requests_) {
    performLayout();
    space_.limitPictures(0.2);
    {
      const std::lock_guard<std::mutex> lock(background_scene_mtx);
      background_scene = space_.scene();
    }
    const mrpt::opengl::CCamera start = space_.camera();
    camera().setCameraProjective(true);
    camera().setCameraFOV(static_cast<float>(SceneView::kFieldOfViewDeg));
    camera().setAzimuthDegrees(start.getAzimuthDegrees());
    camera().setElevationDegrees(start.getElevationDegrees());
    camera().setMinimumZoom(0.01F);
    refresh();
    addLoopCallback([this] { onLoop(); });
    drawAll();
    setVisible(true);
  }
  ~Window() override { endVideo(); }

  std::function<bool()> keep_on;
  std::string last_picture;
  WindowReport report;

  void drawContents() override {
    CDisplayWindowGUI::drawContents();
    for (BlittedPicture* panel : {&legend_, &strips_, &edges_, &masks_}) panel->draw(height());
    const double now = wallClock();
    if (report.frames++ == 0) first_drawn_ = now;
    report.seconds = now - first_drawn_;
    if (!requests_.picture && !requests_.video && !video_) return;
    cv::Mat pixels(height(), width(), CV_8UC3);
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glReadBuffer(GL_BACK);
    glReadPixels(0, 0, pixels.cols, pixels.rows, GL_BGR, GL_UNSIGNED_BYTE, pixels.data);
    cv::flip(pixels, pixels, 0);
    if (requests_.picture) savePicture(pixels);
    recordVideo(pixels, now);
  }

  bool keyboardEvent(int key, int scancode, int action, int modifiers) override {
    constexpr int kPress = 1;  // GLFW_PRESS
    if (action == kPress && controls_.key(key)) return true;
    return CDisplayWindowGUI::keyboardEvent(key, scancode, action, modifiers);
  }

  bool mouseButtonEvent(const nanogui::Vector2i& p, int button, bool down, int modifiers) override {
    constexpr int kControl = 2;  // GLFW_MOD_CONTROL
    Eigen::Vector3d point;
    if (down && button == 0 && (modifiers & kControl) != 0) {
      if (pick(p, &point)) pressed_ = point;
      return true;
    }
    if (!down && pressed_) {
      if (!pick(p, &point)) point = *pressed_;
      source_->setPose(poseFromPick(moment_, *pressed_, point));
      pressed_.reset();
      return true;
    }
    return CDisplayWindowGUI::mouseButtonEvent(p, button, down, modifiers);
  }

  void savePicture(const cv::Mat& pixels) {
    requests_.picture = false;
    const std::string file = last_picture.empty() ? freeName(".png") : last_picture;
    try {
      writePicture(file, pixels);
      std::fprintf(stderr, "picture: %s\n", file.c_str());
    } catch (const InputError& error) {
      std::fprintf(stderr, "warning: %s\n", error.what());
    }
  }
  void requestPicture() { requests_.picture = true; }

  void setMap(const LocalizationMap* map) {
    map_ = map;
    space_.setMap(map);
    has_looked_ = false;
    requests_.changed = true;
  }

 private:
  void onLoop() {
    if (keep_on && !keep_on()) {
      nanogui::leave();
      return;
    }
    // s; the window refreshes a little more often than the screen is drawn.
    constexpr double kPeriod = 0.03;
    if (wallClock() - refreshed_at_ < kPeriod) return;
    refreshed_at_ = wallClock();
    refresh();
  }

  void refresh() {
    const bool resized = shown_size_ != cv::Size(width(), height());
    if (requests_.changed) space_.setParameters(params_);
    const bool news = source_->poll(&moment_, &history_, params_.strip_seconds);
    if (!news && !requests_.changed && !resized) return;
    requests_.changed = false;
    shown_size_ = {width(), height()};
    const std::lock_guard<std::mutex> lock(background_scene_mtx);
    space_.update(moment_, history_);
    const ViewLayout layout = layoutOf(shown_size_, moment_.image.size());
    placeSpace(layout.space);
    legend_.set(drawLegend(moment_, layout.legend.size()), layout.legend);
    strips_.set(drawStrips(moment_, history_, params_.strip_seconds, layout.strips.size()),
                layout.strips);
    edges_.set(drawEdgePanel(moment_, map_, params_, layout.edges.size()), layout.edges);
    masks_.set(drawMaskPanel(moment_, layout.masks.size()), layout.masks);
    const mrpt::opengl::CCamera wanted = space_.camera();
    // The user turns and zooms the camera. Only its focus follows the robot.
    if (params_.follow || !has_looked_)
      camera().setCameraPointing(wanted.getPointingAtX(), wanted.getPointingAtY(),
                                 wanted.getPointingAtZ());
    if (!has_looked_) camera().setZoomDistance(wanted.getZoomDistance());
    has_looked_ = has_looked_ || moment_.has_pose;
    controls_.update();
  }

  void placeSpace(const cv::Rect& area) {
    const double w = shown_size_.width, h = shown_size_.height;
    space_.scene()->getViewport()->setViewportPosition(area.x / w, 1 - (area.y + area.height) / h,
                                                       area.width / w, area.height / h);
    space_area_ = area;
  }

  bool pick(const nanogui::Vector2i& p, Eigen::Vector3d* point) const {
    if (!space_area_.contains({p.x(), p.y()})) return false;
    mrpt::math::TLine3D ray;
    space_.scene()->getViewport()->get3DRayForPixelCoord(p.x() - space_area_.x,
                                                         p.y() - space_area_.y, ray);
    const Eigen::Vector3d from(ray.pBase.x, ray.pBase.y, ray.pBase.z);
    const Eigen::Vector3d along(ray.director[0], ray.director[1], ray.director[2]);
    Eigen::Vector3f hit;
    if (!firstHit(space_.shape(), from.cast<float>(), along.cast<float>(), &hit)) return false;
    *point = hit.cast<double>();
    return true;
  }

  void recordVideo(const cv::Mat& pixels, double now) {
    if (!requests_.video) {
      endVideo();
      return;
    }
    try {
      if (!video_) {
        video_size_ = {pixels.cols & ~1, pixels.rows & ~1};  // videos have even sizes
        video_ = std::make_unique<VideoFile>(freeName(".mp4"), std::vector<std::string>{"mp4v"},
                                             kVideoRate, video_size_);
        video_pace_ = VideoPace(kVideoRate, now);
      }
      int copies = video_pace_.copiesAt(now);
      if (copies == 0) return;
      cv::Mat frame;
      cv::resize(pixels, frame, video_size_);
      for (; copies > 0; --copies) video_->write(frame);
    } catch (const InputError& error) {
      std::fprintf(stderr, "warning: %s\n", error.what());
      requests_.video = false;
    }
  }

  void endVideo() {
    const std::unique_ptr<VideoFile> video = std::move(video_);
    if (!video) return;
    try {
      video->close();
      std::fprintf(stderr, "video: %s\n", video->name().c_str());
    } catch (const InputError& error) {
      std::fprintf(stderr, "warning: %s\n", error.what());
    }
  }

  const LocalizationMap* map_;
  ViewParameters params_;
  ViewSource* source_;
  SceneView space_;
  WindowRequests requests_;
  WindowControls controls_;
  BlittedPicture legend_, strips_, edges_, masks_;
  ViewMoment moment_;
  HistoryView history_;
  cv::Size shown_size_, video_size_;
  cv::Rect space_area_;
  bool has_looked_ = false;
  double refreshed_at_ = 0, first_drawn_ = 0;
  std::optional<Eigen::Vector3d> pressed_;
  std::unique_ptr<VideoFile> video_;
  VideoPace video_pace_{kVideoRate, 0};
};

ViewerWindow::ViewerWindow(const LocalizationMap* map, const ViewParameters& params,
                           ViewSource* source, const std::string& title) {
  params.validate();
  try {
    nanogui::init();
    window_ = std::make_unique<Window>(map, params, source, title);
  } catch (const std::exception& e) {
    throw Error(std::string("no window can be opened here (no display? see --headless): ") +
                e.what());
  }
}

ViewerWindow::~ViewerWindow() {
  window_.reset();
  nanogui::shutdown();
}

void ViewerWindow::setMap(const LocalizationMap* map) { window_->setMap(map); }

WindowReport ViewerWindow::run(const std::function<bool()>& keep_on, const std::string& picture) {
  // The toolkit waits this long from the end of a frame to the begin of the next one.
  constexpr int kIdle = 5, kRepaint = 15;  // ms
  window_->keep_on = keep_on;
  nanogui::mainloop(kIdle, kRepaint);
  if (!picture.empty()) {
    window_->last_picture = picture;
    window_->requestPicture();
    window_->drawAll();
  }
  return window_->report;
}

}  // namespace edge_mcl
