/// The viewer's window: MRPT's, with controls.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "edge_mcl/core/localization_map.h"
#include "edge_mcl/viewer/drawing/view_parameters.h"
#include "edge_mcl/viewer/moments/view_source.h"

namespace edge_mcl {

/// How the window ran.
struct WindowReport {
  size_t frames = 0;   ///< drawn
  double seconds = 0;  ///< between the first and the last
  double rate() const { return seconds > 0 ? static_cast<double>(frames - 1) / seconds : 0; }
};

class ViewerWindow {
 public:
  /// @param map may be null; else it must outlive this object, as must the source.
  /// @throws Error when there is no display or no OpenGL.
  ViewerWindow(const LocalizationMap* map, const ViewParameters& params, ViewSource* source,
               const std::string& title);
  ~ViewerWindow();

  /// A model that comes later, from `keep_on`. It must outlive this object.
  void setMap(const LocalizationMap* map);
  /// Until the window is closed or `keep_on` says no. The thread must be that of the constructor.
  /// @param picture written at the end; empty: none.
  WindowReport run(const std::function<bool()>& keep_on, const std::string& picture = "");

 private:
  class Window;
  std::unique_ptr<Window> window_;
};

}  // namespace edge_mcl
