/// The model and what the localizer knows, as an MRPT scene.
#pragma once

#include <mrpt/opengl/CCamera.h>
#include <mrpt/opengl/COpenGLScene.h>

#include <memory>

#include "edge_mcl/viewer/drawing/view_parameters.h"
#include "edge_mcl/viewer/moments/view_history.h"
#include "edge_mcl/viewer/moments/view_moment.h"
#include "edge_mcl/viewer/scene/model_shape.h"

namespace edge_mcl {

class SceneView {
 public:
  /// @param map may be null: then there is no model to see. It must outlive this object.
  SceneView(const LocalizationMap* map, const ViewParameters& params);
  ~SceneView();

  /// A model that comes later. It must outlive this object.
  void setMap(const LocalizationMap* map);
  /// Changes how the model is shown.
  void setParameters(const ViewParameters& params);
  void update(const ViewMoment& moment, const HistoryView& history);
  /// The picture in the camera's frustum is changed at most once in so many seconds (else with
  /// every moment): each takes a new texture, of which MRPT keeps a record for ever.
  void limitPictures(double period) { picture_period_ = period; }

  const mrpt::opengl::COpenGLScene::Ptr& scene() const { return scene_; }
  /// From where one looks by the parameters.
  mrpt::opengl::CCamera camera() const;
  /// What is shown of the model.
  const ModelShape& shape() const { return shape_; }
  /// Vertical field of view.
  static constexpr double kFieldOfViewDeg = 45;

 private:
  struct Objects;
  void showModel(float height);
  void cutFor(const ViewMoment& moment);
  void showPoses(const ViewMoment& moment, const HistoryView& history);
  void showCamera(const ViewMoment& moment, const Pose& T_map_camera);
  double distanceSeen(const ViewMoment& moment, const Pose& T_map_camera) const;
  void look(const ViewMoment& moment);
  bool isSmall() const;  // an object, not a building

  const LocalizationMap* map_ = nullptr;
  ViewParameters params_;
  mrpt::opengl::COpenGLScene::Ptr scene_;
  std::unique_ptr<Objects> objects_;
  ModelShape shape_;
  std::optional<float> height_;  // at which it is cut
  Eigen::Vector3d focus_ = Eigen::Vector3d::Zero();
  double distance_ = 10;  // from it
  bool has_focus_ = false;
  double picture_period_ = 0, picture_at_ = -1e9;  // s; steady clock
};

}  // namespace edge_mcl
