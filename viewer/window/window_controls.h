/// The buttons and switches of the viewer's window.
#pragma once

#include <mrpt/gui/CDisplayWindowGUI.h>

#include <functional>

#include "edge_mcl/viewer/drawing/view_parameters.h"
#include "edge_mcl/viewer/moments/view_source.h"

namespace edge_mcl {

/// What the user asks of the window itself.
struct WindowRequests {
  bool picture = false;  ///< save one
  bool video = false;    ///< record while it is set
  bool changed = false;  ///< a parameter
};

class WindowControls {
 public:
  /// All must outlive this object; the widgets belong to the screen.
  WindowControls(nanogui::Screen* screen, ViewSource* source, ViewParameters* params,
                 WindowRequests* requests);

  /// Shows where the timeline is.
  void update();
  /// The usual keys: space, arrows, L, P, V. @return false: not one of these.
  bool key(int key);

 private:
  void addTimeline(nanogui::Screen* screen);
  void addSwitches(nanogui::Screen* screen);
  void addSwitch(nanogui::Widget* parent, const std::string& caption, bool* value);
  void step(int by);
  void togglePlay();

  ViewSource* source_;
  ViewParameters* params_;
  WindowRequests* requests_;
  nanogui::Button* play_ = nullptr;
  nanogui::Slider* slider_ = nullptr;
  nanogui::Label* position_ = nullptr;
};

}  // namespace edge_mcl
