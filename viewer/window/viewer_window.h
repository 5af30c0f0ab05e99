/// Opens the viewer's window with its controls.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "edge_mcl/core/localization_map.h"
#include "edge_mcl/viewer/drawing/view_parameters.h"
#include "edge_mcl/viewer/moments/view_source.h"

namespace edge_mcl {

/// Figures of how the window ran.
struct WindowReport {
  size_t frames = 0;   ///< number of frames drawn
  double seconds = 0;  ///< from the first to the last frame
  /// Frames per second.
  double rate() const { return seconds > 0 ? static_cast<double>(frames - 1) / seconds : 0; }
};

/// A window of MRPT that shows the moments of a source. The same thread must make and run it.
class ViewerWindow {
 public:
  /// @param map may be null; otherwise it must outlive this object. @param source must outlive this
  /// object. @throws Error when there is no display or no OpenGL; ParameterError.
  ViewerWindow(const LocalizationMap* map, const ViewParameters& params, ViewSource* source,
               const std::string& title);
  ~ViewerWindow();

  /// Sets the model when it comes later; may be called from `keep_on`. It must outlive this object.
  void setMap(const LocalizationMap* map);
  /// Runs until the user closes the window or `keep_on` returns false. @param keep_on is called in
  /// every loop; may be empty. @param picture file for a picture of the window at the end; empty:
  /// none.
  WindowReport run(const std::function<bool()>& keep_on, const std::string& picture = "");

 private:
  class Window;
  std::unique_ptr<Window> window_;
};

}  // namespace edge_mcl
