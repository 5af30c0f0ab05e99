/// A recorded sequence as an MRPT rawlog.
#pragma once

#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CSensoryFrame.h>

#include "edge_mcl/core/parameters.h"
#include "edge_mcl/core/sequence.h"

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

}  // namespace edge_mcl
