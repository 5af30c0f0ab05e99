#include "edge_mcl/core/recordings/recording.h"

namespace edge_mcl {

RecordedFrame loadFrame(const Sequence& sequence, const SequenceFrame& frame) {
  RecordedFrame loaded;
  loaded.time = frame.time;
  loaded.color = readImage(frame.image_file, sequence.camera);
  if (!frame.mask_file.empty()) loaded.mask = readMask(frame.mask_file, sequence.camera);
  loaded.truth = frame.ground_truth;
  loaded.odometry = frame.odometry;
  return loaded;
}

RecordingSetup setupOf(const Sequence& sequence, const Pose& T_base_camera) {
  RecordingSetup setup;
  setup.camera = sequence.camera;
  setup.T_base_camera = T_base_camera;
  setup.depth_scale = sequence.depth_scale;
  setup.initial_pose = startOf(sequence);
  setup.initial_std_position = sequence.initial_std_position;
  setup.initial_std_angle = sequence.initial_std_angle;
  return setup;
}

}  // namespace edge_mcl
