/// Draws the picture of the viewer's window without a window.
#pragma once

#include <memory>

#include "edge_mcl/viewer/drawing/panels.h"
#include "edge_mcl/viewer/drawing/view_layout.h"
#include "edge_mcl/viewer/scene/scene_view.h"

namespace edge_mcl {

/// Renders with EGL; without a graphics card it renders in software. Only the thread that made the
/// object may use it. The layout of the first picture stays, even when later images have another
/// size: MRPT keeps shaders and buffers per thread, so a second renderer cannot draw the scene.
class HeadlessView {
 public:
  /// @param map may be null; otherwise it must outlive this object. @throws ParameterError
  HeadlessView(const LocalizationMap* map, const ViewParameters& params);
  ~HeadlessView();

  /// Draws a moment. @return CV_8UC3 of the size that the parameters give. @throws InputError when
  /// the machine cannot render, e.g. without EGL.
  cv::Mat draw(const ViewMoment& moment, const HistoryView& history);
  /// Sets the model when it comes later. It must outlive this object.
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
