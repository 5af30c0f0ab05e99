// The main loops of the viewer node, with and without a window.
#include <ros/console.h>
#include <ros/spinner.h>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/nodes/common/caller_path.h"
#include "edge_mcl/nodes/common/private_parameters.h"
#include "edge_mcl/nodes/localizer/node_parameters.h"
#include "edge_mcl/nodes/viewer/viewer_node.h"
#include "edge_mcl/nodes/viewer/viewer_run.h"
#include "edge_mcl/viewer/output/view_recorder.h"
#include "edge_mcl/viewer/window/viewer_window.h"

namespace edge_mcl {

namespace {

/// Takes model and frames from the localizer's parameters where the viewer has none of its own.
/// @return parameters of the localizer's method, because the viewer must read the model in the same
/// way
Parameters adoptFromLocalizer(const ros::NodeHandle& nh, ViewerNodeParameters* params) {
  NodeParameters localizer;
  Parameters method;
  try {
    applyParameters(readPrivateParameters(ros::NodeHandle(nh, params->localizer)), &localizer,
                    &method);
    // The viewer only draws the surfaces, so it needs no distance field for depth images.
    method.likelihood.cues = Cues::kEdges;
  } catch (const ParameterError& e) {
    ROS_WARN("parameters of %s: %s", params->localizer.c_str(), e.what());
    method = Parameters();
  }
  // roslaunch starts both nodes, so both find relative names in the same folder.
  if (params->model.empty() && !localizer.model_file.empty())
    params->model = callerPath(localizer.model_file);
  if (params->camera_file.empty()) params->camera_file = localizer.cameraFiles().front();
  if (params->image_transport.empty()) params->image_transport = localizer.image_transport;
  if (params->rectified.empty()) params->rectified = localizer.rectified;
  if (params->global_frame_id.empty()) params->global_frame_id = localizer.global_frame_id;
  if (params->base_frame_id.empty()) params->base_frame_id = localizer.base_frame_id;
  return method;
}

/// The model that the viewer shows.
class ShownModel {
 public:
  /// @param params empty values are filled from the localizer's parameters.
  ShownModel(const ros::NodeHandle& nh, ViewerNodeParameters* params) : nh_(nh), given_(*params) {
    load(params);
  }

  const LocalizationMap* map() const { return map_.get(); }
  /// Loads the model at the first status, when the localizer began after the viewer. @return the
  /// model when this call has loaded it, otherwise null
  const LocalizationMap* comesLate(LiveView* view) {
    if (map_ || asked_again_ || !view->hasStatus()) return nullptr;
    asked_again_ = true;
    ViewerNodeParameters params = given_;
    try {
      load(&params);
    } catch (const Error& e) {
      ROS_WARN("%s", e.what());
    }
    view->setFrames(params.global_frame_id, params.base_frame_id);
    if (map_)
      ROS_INFO("showing the model of %s: %s", params.localizer.c_str(), params.model.c_str());
    return map_.get();
  }

 private:
  void load(ViewerNodeParameters* params) {
    const Parameters method = adoptFromLocalizer(nh_, params);
    if (!params->model.empty()) map_ = std::make_unique<LocalizationMap>(params->model, method);
  }

  ros::NodeHandle nh_;
  const ViewerNodeParameters given_;
  std::unique_ptr<LocalizationMap> map_;
  bool asked_again_ = false;
};

void record(const ViewerNodeParameters& params, ShownModel* model, LiveView* view) {
  RecorderOptions options;
  options.video = params.video;
  options.video_rate = params.video_rate;
  options.pictures = params.pictures;
  options.at = params.pictureTimes();
  ViewRecorder recorder(model->map(), params, options);
  int moments = 0;
  ros::WallTime said_at;
  ViewMoment moment;
  while (ros::ok() && (params.moments == 0 || moments < params.moments)) {
    if (!view->next(&moment)) {
      // By the wall clock, because the simulated clock may stand still when nothing arrives.
      const std::string missing = view->whatIsMissing();
      if (!missing.empty() && (ros::WallTime::now() - said_at).toSec() > 5) {
        said_at = ros::WallTime::now();
        ROS_WARN("%s", missing.c_str());
      }
      ros::WallDuration(0.01).sleep();
      continue;
    }
    if (const LocalizationMap* map = model->comesLate(view)) recorder.setMap(map);
    recorder.show(moment);
    if (!moment.problem.empty()) ROS_WARN_THROTTLE(2, "%s", moment.problem.c_str());
    ++moments;
  }
  recorder.close();
  // Not by the console of ROS, because ROS may be shut down already.
  std::printf("%s\n", recorder.summary().c_str());
  for (const std::string& file : recorder.written()) std::printf("%s\n", file.c_str());
}

}  // namespace

void runViewer(const ros::NodeHandle& nh, const ros::NodeHandle& private_nh) {
  auto params = readParameterStruct<ViewerNodeParameters>(private_nh);
  ShownModel model(nh, &params);
  LiveView view(nh, params);
  ros::AsyncSpinner spinner(1);
  spinner.start();
  if (params.headless) {
    record(params, &model, &view);
    return;
  }
  ViewerWindow window(model.map(), params, &view, "edge_mcl");
  window.run([&] {
    if (const LocalizationMap* map = model.comesLate(&view)) window.setMap(map);
    return ros::ok();
  });
}

}  // namespace edge_mcl
