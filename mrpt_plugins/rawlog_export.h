/// Recordings as MRPT rawlogs.
#pragma once

#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CSensoryFrame.h>

#include <memory>

#include "edge_mcl/core/base/parameters.h"
#include "edge_mcl/core/recordings/recording.h"
#include "edge_mcl/core/recordings/sequence.h"

namespace edge_mcl {

/// Motion of the base between two images, as an action with a Gaussian. Without odometry: no
/// motion, with the noise of the constant-velocity model (MRPT's filters demand an action).
mrpt::obs::CActionCollection::Ptr makeAction(const SequenceFrame& from, const SequenceFrame& to,
                                             const Pose& T_base_camera,
                                             const FilterParameters& noise);

/// Image (grey), mask and ground truth (CObservationRobotPose 'ground_truth') of one frame.
/// @throws InputError when the image or mask cannot be read.
mrpt::obs::CSensoryFrame::Ptr makeSensoryFrame(const Sequence& sequence, const SequenceFrame& frame,
                                               const Pose& T_base_camera, bool with_mask);

/// Pairs of action and sensory frame, in a compressed file. Has no place for depth and IMU. Written
/// as FILE.part, renamed by close().
class RawlogWriter : public Recorder {
 public:
  /// @param file must not exist. @param noise of the actions.
  RawlogWriter(const std::string& file, const RecordingSetup& setup, const FilterParameters& noise);
  ~RawlogWriter() override;
  void write(const RecordedFrame& frame) override;
  void writeImu(const std::vector<ImuReading>&) override {}
  void close() override;
  size_t count() const override { return count_; }

 private:
  struct File;
  std::string partial() const { return name_ + ".part"; }
  std::string name_;
  RecordingSetup setup_;
  FilterParameters noise_;
  std::unique_ptr<File> file_;
  std::optional<RecordedFrame> last_;  // without pictures
  size_t count_ = 0;
};

}  // namespace edge_mcl
