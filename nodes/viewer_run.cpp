// The viewer node's main loops, with and without a window.
#include <ros/console.h>
#include <ros/spinner.h>

#include "edge_mcl/core/error.h"
#include "edge_mcl/nodes/node_parameters.h"
#include "edge_mcl/nodes/private_parameters.h"
#include "edge_mcl/nodes/viewer_node.h"
#include "edge_mcl/viewer/view_recorder.h"
#include "edge_mcl/viewer/viewer_window.h"

namespace edge_mcl {

namespace {

/// What the viewer is not told it takes from the localizer: how the model is read must be the same.
Parameters adoptFromLocalizer(const ros::NodeHandle& nh, ViewerNodeParameters* params) {
  NodeParameters localizer;
  Parameters method;
  try {
    applyParameters(readPrivateParameters(ros::NodeHandle(nh, params->localizer)), &localizer,
                    &method);
    // Of surfaces only what is seen is needed here.
    method.likelihood.cues = Cues::kEdges;
  } catch (const ParameterError& e) {
    ROS_WARN("parameters of %s: %s", params->localizer.c_str(), e.what());
    method = Parameters();
  }
  if (params->model.empty()) params->model = localizer.model_file;
  if (params->global_frame_id.empty()) params->global_frame_id = localizer.global_frame_id;
  if (params->base_frame_id.empty()) params->base_frame_id = localizer.base_frame_id;
  return method;
}

void record(const ViewerNodeParameters& params, const LocalizationMap* map, LiveView* view) {
  RecorderOptions options;
  options.video = params.video;
  options.video_rate = params.video_rate;
  options.pictures = params.pictures;
  options.at = params.pictureTimes();
  ViewRecorder recorder(map, params, options);
  int moments = 0;
  ros::WallTime said_at;
  ViewMoment moment;
  while (ros::ok() && (params.moments == 0 || moments < params.moments)) {
    if (!view->next(&moment)) {
      // By the wall's clock: where nothing comes the simulated one may stand, too.
      const std::string missing = view->whatIsMissing();
      if (!missing.empty() && (ros::WallTime::now() - said_at).toSec() > 5) {
        said_at = ros::WallTime::now();
        ROS_WARN("%s", missing.c_str());
      }
      ros::WallDuration(0.01).sleep();
      continue;
    }
    recorder.show(moment);
    if (!moment.problem.empty()) ROS_WARN_THROTTLE(2, "%s", moment.problem.c_str());
    ++moments;
  }
  recorder.close();
  // ROS may have ended, and its console with it.
  std::printf("%s\n", recorder.summary().c_str());
  for (const std::string& file : recorder.written()) std::printf("%s\n", file.c_str());
}

}  // namespace

void runViewer(const ros::NodeHandle& nh, const ros::NodeHandle& private_nh) {
  auto params = readParameterStruct<ViewerNodeParameters>(private_nh);
  const Parameters method = adoptFromLocalizer(nh, &params);
  std::unique_ptr<LocalizationMap> map;
  if (!params.model.empty()) map = std::make_unique<LocalizationMap>(params.model, method);
  LiveView view(nh, params);
  ros::AsyncSpinner spinner(1);
  spinner.start();
  if (params.headless) {
    record(params, map.get(), &view);
    return;
  }
  ViewerWindow window(map.get(), params, &view, "edge_mcl");
  window.run([] { return ros::ok(); });
}

}  // namespace edge_mcl
