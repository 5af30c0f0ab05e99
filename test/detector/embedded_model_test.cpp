// Tests the embedded network on a flight of the simulator. Its training data held neither these
// objects nor these rooms.
#include <gtest/gtest.h>

#include "edge_mcl/detector/default_model.h"
#include "edge_mcl/detector/mask_detector.h"
#include "edge_mcl/sim/simulator.h"

namespace edge_mcl {
namespace {

/// The truth is the masks of the simulator.
TEST(EmbeddedModel, FindsWhatIsNotInTheMap) {
  Simulator simulator(Scenario::fromYamlFile(std::string(EDGE_MCL_MAPS) + "/office_flight.yaml"));
  MaskDetector detector(DetectorModel::fromYamlFile(defaultModelFile()), {});
  double both = 0, truth = 0, found = 0;
  RecordedFrame frame;
  for (size_t i = 0; i < simulator.imageCount(); i += 30) {
    const double time = simulator.timeOf(i);
    if (!simulator.take(time, simulator.scenario().cameraAt(time), true, &frame)) continue;
    const cv::Mat mask = combinedMask(detector.detect(frame.color), frame.color.size(), 0);
    both += cv::countNonZero(mask & frame.mask);
    truth += cv::countNonZero(frame.mask);
    found += cv::countNonZero(mask);
  }
  ASSERT_GT(truth, 0);
  EXPECT_GT(both / truth, 0.5) << "recall of pixels";
  EXPECT_GT(both / found, 0.5) << "precision of pixels";
}

}  // namespace
}  // namespace edge_mcl
