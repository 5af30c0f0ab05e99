/// Shows the model, the particles and the pose as an MRPT scene.
#pragma once

#include <mrpt/opengl/CCamera.h>
#include <mrpt/opengl/COpenGLScene.h>

#include <memory>

#include "edge_mcl/viewer/drawing/view_parameters.h"
#include "edge_mcl/viewer/moments/view_history.h"
#include "edge_mcl/viewer/moments/view_moment.h"
#include "edge_mcl/viewer/scene/model_shape.h"

namespace edge_mcl {

/// The 3D scene of the viewer.
class SceneView {
 public:
  /// @param map may be null: then the scene has no model. It must outlive this object.
  SceneView(const LocalizationMap* map, const ViewParameters& params);
  ~SceneView();

  /// Sets the model when it comes later. It must outlive this object.
  void setMap(const LocalizationMap* map);
  /// Changes how the model is shown.
  void setParameters(const ViewParameters& params);
  /// Shows a moment.
  void update(const ViewMoment& moment, const HistoryView& history);
  /// Limits how often the camera image in the frustum changes. Without a limit it changes with
  /// every moment. Every change takes a new texture, and MRPT never frees its record of a texture.
  /// @param period shortest time between two changes, s.
  void limitPictures(double period) { picture_period_ = period; }

  const mrpt::opengl::COpenGLScene::Ptr& scene() const { return scene_; }
  /// Viewpoint that follows from the parameters and the pose.
  mrpt::opengl::CCamera camera() const;
  /// Part of the model that is shown.
  const ModelShape& shape() const { return shape_; }
  /// Vertical field of view, deg.
  static constexpr double kFieldOfViewDeg = 45;

 private:
  struct Objects;
  void showModel(float height);
  void cutFor(const ViewMoment& moment);
  void showPoses(const ViewMoment& moment, const HistoryView& history);
  void showCamera(const ViewMoment& moment, const Pose& T_map_camera);
  double distanceSeen(const ViewMoment& moment, const Pose& T_map_camera) const;
  void look(const ViewMoment& moment);
  bool isSmall() const;  // whether the model is an object and not a building

  const LocalizationMap* map_ = nullptr;
  ViewParameters params_;
  mrpt::opengl::COpenGLScene::Ptr scene_;
  std::unique_ptr<Objects> objects_;
  ModelShape shape_;
  std::optional<float> height_;  // map z at which the model is cut, m
  Eigen::Vector3d focus_ = Eigen::Vector3d::Zero();
  double distance_ = 10;  // of the viewpoint from the focus, m
  bool has_focus_ = false;
  double picture_period_ = 0, picture_at_ = -1e9;  // s, steady clock
};

}  // namespace edge_mcl
