/// The window's picture without a window.
#pragma once

#include <memory>

#include "edge_mcl/viewer/drawing/panels.h"
#include "edge_mcl/viewer/drawing/view_layout.h"
#include "edge_mcl/viewer/scene/scene_view.h"

namespace edge_mcl {

/// Renders with EGL, in software where there is no graphics card. To be used by the thread that
/// made it. The first picture's layout stays, whatever sizes images have later: MRPT keeps shaders
/// and buffers per thread, so a scene cannot be drawn in a second renderer.
class HeadlessView {
 public:
  /// @param map may be null; else it must outlive this object.
  HeadlessView(const LocalizationMap* map, const ViewParameters& params);
  ~HeadlessView();

  /// @return CV_8UC3 of the parameters' size. @throws InputError when nothing can be rendered here.
  cv::Mat draw(const ViewMoment& moment, const HistoryView& history);
  /// A model that comes later. It must outlive this object.
  void setMap(const LocalizationMap* map);
  const SceneView& space() const { return space_; }

 private:
  struct Renderer;
  const LocalizationMap* map_;
  ViewParameters params_;
  SceneView space_;
  ViewLayout layout_;  // of the first picture
  std::unique_ptr<Renderer> renderer_;
};

}  // namespace edge_mcl
