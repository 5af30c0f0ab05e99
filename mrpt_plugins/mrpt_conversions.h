/// Between MRPT's types and those of core/.
#pragma once

#include <mrpt/img/TCamera.h>
#include <mrpt/math/CMatrixFixed.h>
#include <mrpt/math/TPose3D.h>
#include <mrpt/poses/CPose3D.h>

#include <string>

#include "edge_mcl/core/base/se3.h"
#include "edge_mcl/core/camera/camera_model.h"

namespace edge_mcl {

Pose toPose(const mrpt::poses::CPose3D& pose);
Pose toPose(const mrpt::math::TPose3D& pose);
mrpt::poses::CPose3D toMrpt(const Pose& pose);

/// Covariance of (x, y, z, yaw, pitch, roll), MRPT's order, from the tangent space at the mean.
/// First order; undefined at a pitch of +-90 degrees, as MRPT's own parametrisation.
mrpt::math::CMatrixDouble66 toMrptCovariance(const PoseGaussian& gaussian);

/// @throws InputError on a camera without size or focal length.
CameraModel toCameraModel(const mrpt::img::TCamera& camera, const std::string& origin);
/// @throws Error for a model that MRPT cannot express (none of those in CameraModel).
mrpt::img::TCamera toMrpt(const CameraModel& camera);

}  // namespace edge_mcl
