/// Makes the buttons and switches of the viewer's window.
#pragma once

#include <mrpt/gui/CDisplayWindowGUI.h>

#include <functional>

#include "edge_mcl/viewer/drawing/view_parameters.h"
#include "edge_mcl/viewer/moments/view_source.h"

namespace edge_mcl {

/// Requests of the user to the window itself.
struct WindowRequests {
  bool picture = false;  ///< save a picture
  bool video = false;    ///< record a video while this is true
  bool changed = false;  ///< a parameter has changed
};

/// Buttons, switches and keys of the window.
class WindowControls {
 public:
  /// All arguments must outlive this object. The widgets belong to the screen.
  WindowControls(nanogui::Screen* screen, ViewSource* source, ViewParameters* params,
                 WindowRequests* requests);

  /// Shows the present position of the timeline.
  void update();
  /// Handles the keys space, left, right, L, P and V. @return false for any other key.
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
