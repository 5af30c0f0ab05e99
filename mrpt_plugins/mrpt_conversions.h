/// Conversions between types of MRPT and types of core/.
#pragma once

#include <mrpt/img/TCamera.h>
#include <mrpt/math/CMatrixFixed.h>
#include <mrpt/math/TPose3D.h>
#include <mrpt/poses/CPose3D.h>

#include <string>

#include "edge_mcl/core/base/se3.h"
#include "edge_mcl/core/camera/camera_model.h"

namespace edge_mcl {

/// Converts a pose; the frames stay the same.
Pose toPose(const mrpt::poses::CPose3D& pose);
Pose toPose(const mrpt::math::TPose3D& pose);
mrpt::poses::CPose3D toMrpt(const Pose& pose);

/// Converts a covariance in the tangent space at the mean to the covariance of (x, y, z, yaw,
/// pitch, roll), MRPT's order, in metres and radians. The conversion is of first order. It is
/// undefined at a pitch of +-90 degrees, like MRPT's own parametrisation.
mrpt::math::CMatrixDouble66 toMrptCovariance(const PoseGaussian& gaussian);

/// Converts a camera model. @param origin named in errors. @throws InputError on a camera without
/// size or focal length.
CameraModel toCameraModel(const mrpt::img::TCamera& camera, const std::string& origin);
/// Converts a camera model. MRPT can express all models of CameraModel.
mrpt::img::TCamera toMrpt(const CameraModel& camera);

}  // namespace edge_mcl
