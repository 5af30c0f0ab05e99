/// A moment of a simulated flight as the viewer gets it.
#pragma once

#include <memory>

#include "edge_mcl/core/localization_map.h"
#include "edge_mcl/sim/simulator.h"
#include "edge_mcl/viewer/moments/view_moment.h"

namespace edge_mcl::test {

struct SimulatedMoment {
  Scenario scenario = Scenario::fromYamlFile(std::string(EDGE_MCL_TEST_DATA) + "small_flight.yaml");
  std::shared_ptr<LocalizationMap> map;
  ViewMoment moment;

  SimulatedMoment() {
    map = std::make_shared<LocalizationMap>(scenario.model_file, Parameters());
    Simulator simulator(scenario);
    RecordedFrame frame;
    simulator.next(&frame);
    moment.time = frame.time;
    moment.state = LocalizerState::kTracking;
    moment.has_pose = true;
    moment.estimate.mean = *frame.truth;
    moment.estimate.covariance.diagonal().setConstant(1e-4);
    moment.truth = frame.truth;
    moment.has_camera = true;
    moment.camera = scenario.camera;
    moment.image = frame.color;
    moment.mask = frame.mask;
    moment.times.stage[2] = 12;
    moment.times.total = 20;
    moment.effective_sample_size = 120;
  }
};

/// Whether any pixel within `reach` of a place has about this colour. @param tolerance largest sum
/// of the differences of the three channels
inline bool hasColorNear(const cv::Mat& picture, cv::Point at, const cv::Scalar& color, int reach,
                         double tolerance) {
  for (int y = std::max(0, at.y - reach); y <= std::min(picture.rows - 1, at.y + reach); ++y)
    for (int x = std::max(0, at.x - reach); x <= std::min(picture.cols - 1, at.x + reach); ++x) {
      const cv::Vec3b& p = picture.at<cv::Vec3b>(y, x);
      if (std::abs(p[0] - color[0]) + std::abs(p[1] - color[1]) + std::abs(p[2] - color[2]) <
          tolerance)
        return true;
    }
  return false;
}

}  // namespace edge_mcl::test
