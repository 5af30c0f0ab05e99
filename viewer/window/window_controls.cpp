#include "edge_mcl/viewer/window/window_controls.h"

#include <nanogui/opengl.h>

#include <algorithm>
#include <cmath>

namespace edge_mcl {

WindowControls::WindowControls(nanogui::Screen* screen, ViewSource* source, ViewParameters* params,
                               WindowRequests* requests)
    : source_(source), params_(params), requests_(requests) {
  addSwitches(screen);
  if (source_->timeline()) addTimeline(screen);
}

void WindowControls::step(int by) {
  const std::optional<Timeline> t = source_->timeline();
  if (!t) return;
  source_->play(false);
  const long wanted = static_cast<long>(t->position) + by;
  source_->seek(static_cast<size_t>(std::max(0L, wanted)));
}

void WindowControls::togglePlay() {
  if (const std::optional<Timeline> t = source_->timeline()) source_->play(!t->playing);
}

void WindowControls::addTimeline(nanogui::Screen* screen) {
  auto* window = new nanogui::Window(screen, "");
  window->setPosition({8, 56});
  window->setLayout(
      new nanogui::BoxLayout(nanogui::Orientation::Horizontal, nanogui::Alignment::Middle, 4, 4));
  const auto button = [&](int icon, const char* tip, const std::function<void()>& action) {
    auto* b = window->add<nanogui::Button>("", icon);
    b->setTooltip(tip);
    b->setCallback(action);
    return b;
  };
  button(ENTYPO_ICON_CONTROLLER_JUMP_TO_START, "one image back (left)", [this] { step(-1); });
  play_ = button(ENTYPO_ICON_CONTROLLER_PLAY, "play, pause (space)", [this] { togglePlay(); });
  button(ENTYPO_ICON_CONTROLLER_NEXT, "next image (right)", [this] { step(1); });
  button(ENTYPO_ICON_HELP, "go to where the robot is lost next (L)",
         [this] { source_->findLost(); });
  slider_ = window->add<nanogui::Slider>();
  slider_->setFixedWidth(220);
  slider_->setCallback([this](float share) {
    const std::optional<Timeline> t = source_->timeline();
    if (!t || t->total == 0) return;
    source_->play(false);
    source_->seek(static_cast<size_t>(std::lround(share * static_cast<float>(t->total - 1))));
  });
  position_ = window->add<nanogui::Label>("0 / 0");
  position_->setFixedWidth(110);
  auto* speed = window->add<nanogui::ComboBox>(
      std::vector<std::string>{"1/4 x", "1/2 x", "1 x", "2 x", "4 x"});
  speed->setSelectedIndex(2);
  speed->setCallback([this](int index) { source_->setSpeed(0.25 * (1 << index)); });
}

void WindowControls::addSwitch(nanogui::Widget* parent, const std::string& caption, bool* value) {
  auto* box = new nanogui::CheckBox(parent, caption, [this, value](bool on) {
    *value = on;
    requests_->changed = true;
  });
  box->setChecked(*value);
}

void WindowControls::addSwitches(nanogui::Screen* screen) {
  auto* window = new nanogui::Window(screen, "");
  window->setPosition({8, 8});
  window->setLayout(
      new nanogui::BoxLayout(nanogui::Orientation::Horizontal, nanogui::Alignment::Middle, 4, 6));
  const std::vector<std::string> styles{"solid", "ghost", "wireframe"};
  auto* style = window->add<nanogui::ComboBox>(styles);
  style->setSelectedIndex(static_cast<int>(
      std::find(styles.begin(), styles.end(), params_->model_style) - styles.begin()));
  style->setCallback([this, styles](int index) {
    params_->model_style = styles[static_cast<size_t>(index)];
    requests_->changed = true;
  });
  addSwitch(window, "follow", &params_->follow);
  addSwitch(window, "model", &params_->model_edges);
  addSwitch(window, "edges", &params_->image_edges);
  addSwitch(window, "normals", &params_->normals);
  addSwitch(window, "mask", &params_->mask);
  addSwitch(window, "depth", &params_->depth_points);
  auto* picture = window->add<nanogui::Button>("", ENTYPO_ICON_CAMERA);
  picture->setTooltip("save a picture (P)");
  picture->setCallback([this] { requests_->picture = true; });
  auto* video = window->add<nanogui::Button>("", ENTYPO_ICON_VIDEO);
  video->setTooltip("record a video (V)");
  video->setFlags(nanogui::Button::ToggleButton);
  video->setChangeCallback([this](bool on) { requests_->video = on; });
}

void WindowControls::update() {
  const std::optional<Timeline> t = source_->timeline();
  if (!t || slider_ == nullptr) return;
  const auto last = static_cast<float>(std::max<size_t>(1, t->total > 0 ? t->total - 1 : 1));
  slider_->setValue(static_cast<float>(t->position) / last);
  slider_->setHighlightedRange({0.0F, static_cast<float>(t->available) / (last + 1)});
  position_->setCaption(std::to_string(t->position + 1) + " / " + std::to_string(t->total));
  play_->setIcon(t->playing ? ENTYPO_ICON_CONTROLLER_PAUS : ENTYPO_ICON_CONTROLLER_PLAY);
}

bool WindowControls::key(int key) {
  switch (key) {
    case GLFW_KEY_SPACE:
      togglePlay();
      return true;
    case GLFW_KEY_LEFT:
      step(-1);
      return true;
    case GLFW_KEY_RIGHT:
      step(1);
      return true;
    case GLFW_KEY_L:
      source_->findLost();
      return true;
    case GLFW_KEY_P:
      requests_->picture = true;
      return true;
    case GLFW_KEY_V:
      requests_->video = !requests_->video;
      return true;
    default:
      return false;
  }
}

}  // namespace edge_mcl
