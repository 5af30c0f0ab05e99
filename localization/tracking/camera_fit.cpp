#include "edge_mcl/localization/tracking/camera_fit.h"

namespace edge_mcl {

std::vector<CameraView> viewsOf(const AskedImage& asked, const CameraModel& camera) {
  return {{asked.map.prepare(camera, asked.image, asked.mask, "image"), asked.T_base_camera, 1,
           nullptr}};
}

double fitOf(const LocalizationMap& map, const std::vector<CameraView>& views, const Pose& start) {
  const Pose refined = map.refineRoughly(views, start, std::nullopt).pose;
  return map.evaluate(views, {refined}).front().log_likelihood;
}

}  // namespace edge_mcl
