/// Recordings of a small camera, for tests of rawlogs.
#pragma once

#include <opencv2/core.hpp>

#include "edge_mcl/core/recordings/recording.h"

namespace edge_mcl::test {

/// A frame with an image of noise, which does not compress.
inline RecordedFrame noisy(double time) {
  RecordedFrame frame;
  frame.time = time;
  frame.color = cv::Mat(60, 80, CV_8UC1);
  cv::randu(frame.color, 0, 256);
  return frame;
}

inline RecordingSetup smallSetup() {
  RecordingSetup setup;
  setup.camera.width = 80;
  setup.camera.height = 60;
  setup.camera.fx = setup.camera.fy = 70;
  setup.camera.cx = 40;
  setup.camera.cy = 30;
  return setup;
}

}  // namespace edge_mcl::test
