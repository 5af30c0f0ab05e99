/// Writes recordings as MRPT rawlogs.
#pragma once

#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CSensoryFrame.h>

#include <memory>

#include "edge_mcl/core/base/parameters.h"
#include "edge_mcl/core/recordings/recording.h"
#include "edge_mcl/core/recordings/sequence.h"

namespace edge_mcl {

/// Makes an action of the motion of the base between two images, with a Gaussian. Without odometry
/// the action holds no motion, with the noise of the constant-velocity model, because MRPT's
/// filters need an action. @param noise parameters of the motion's noise.
mrpt::obs::CActionCollection::Ptr makeAction(const SequenceFrame& from, const SequenceFrame& to,
                                             const Pose& T_base_camera,
                                             const FilterParameters& noise);

/// Makes a sensory frame of one frame of a sequence: the image (grey), its mask, and the ground
/// truth T_map_base (CObservationRobotPose 'ground_truth') if there is one.
/// @throws InputError when image or mask cannot be read.
mrpt::obs::CSensoryFrame::Ptr makeSensoryFrame(const Sequence& sequence, const SequenceFrame& frame,
                                               const Pose& T_base_camera, bool with_mask);

/// Writes pairs of action and sensory frame to a compressed file. Depth images and IMU readings are
/// not written, because these pairs have no place for them. The file is FILE.part until close()
/// renames it.
class RawlogWriter : public Recorder {
 public:
  /// @param file must not exist yet. @param noise parameters of the noise of the actions.
  /// @throws InputError when the file exists or cannot be written.
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
  std::optional<RecordedFrame> last_;  // without images
  size_t count_ = 0;
};

}  // namespace edge_mcl
