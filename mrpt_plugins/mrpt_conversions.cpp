#include "edge_mcl/mrpt_plugins/mrpt_conversions.h"

#include <cmath>

namespace edge_mcl {

Pose toPose(const mrpt::poses::CPose3D& pose) {
  Pose result = Pose::Identity();
  const auto& r = pose.getRotationMatrix();
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) result.linear()(i, j) = r(i, j);
    result.translation()[i] = pose[i];
  }
  return result;
}

Pose toPose(const mrpt::math::TPose3D& pose) { return toPose(mrpt::poses::CPose3D(pose)); }

mrpt::poses::CPose3D toMrpt(const Pose& pose) {
  mrpt::math::CMatrixDouble44 m;
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) m(i, j) = pose.matrix()(i, j);
  return mrpt::poses::CPose3D(m);
}

mrpt::math::CMatrixDouble66 toMrptCovariance(const PoseGaussian& gaussian) {
  // Derivative of (x, y, z, yaw, pitch, roll) by the tangent vector, from central differences.
  constexpr double kStep = 1e-6;
  const auto coordinates = [](const Pose& pose) {
    const mrpt::poses::CPose3D p = toMrpt(pose);
    Twist c;
    c << p.x(), p.y(), p.z(), p.yaw(), p.pitch(), p.roll();
    return c;
  };
  Matrix6 jacobian;
  for (int k = 0; k < 6; ++k) {
    const Twist xi = kStep * Twist::Unit(k);
    Twist d = coordinates(gaussian.mean * expSe3(xi)) - coordinates(gaussian.mean * expSe3(-xi));
    for (int a = 3; a < 6; ++a) d[a] = std::remainder(d[a], 2 * M_PI);
    jacobian.col(k) = d / (2 * kStep);
  }
  const Matrix6 c = jacobian * gaussian.covariance * jacobian.transpose();
  mrpt::math::CMatrixDouble66 result;
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j) result(i, j) = c(i, j);
  return result;
}

CameraModel toCameraModel(const mrpt::img::TCamera& camera, const std::string& origin) {
  CameraModel model;
  model.width = static_cast<int>(camera.ncols);
  model.height = static_cast<int>(camera.nrows);
  model.fx = camera.fx();
  model.fy = camera.fy();
  model.cx = camera.cx();
  model.cy = camera.cy();
  switch (camera.distortion) {
    case mrpt::img::DistortionModel::none:
      break;
    case mrpt::img::DistortionModel::plumb_bob:
      // MRPT keeps the terms of the rational model in the same array.
      model.distortion = DistortionModel::kRationalPolynomial;
      model.coefficients = camera.dist;
      if (camera.dist[5] == 0 && camera.dist[6] == 0 && camera.dist[7] == 0)
        model.distortion = DistortionModel::kPlumbBob;
      break;
    case mrpt::img::DistortionModel::kannala_brandt:
      model.distortion = DistortionModel::kEquidistant;
      model.coefficients = {camera.k1(), camera.k2(), camera.k3(), camera.k4(), 0, 0, 0, 0};
      break;
  }
  model.validate(origin);
  return model;
}

mrpt::img::TCamera toMrpt(const CameraModel& camera) {
  mrpt::img::TCamera result;
  result.ncols = static_cast<uint32_t>(camera.width);
  result.nrows = static_cast<uint32_t>(camera.height);
  result.setIntrinsicParamsFromValues(camera.fx, camera.fy, camera.cx, camera.cy);
  switch (camera.distortion) {
    case DistortionModel::kNone:
      result.distortion = mrpt::img::DistortionModel::none;
      break;
    case DistortionModel::kPlumbBob:
    case DistortionModel::kRationalPolynomial:
      result.distortion = mrpt::img::DistortionModel::plumb_bob;
      result.dist = camera.coefficients;
      break;
    case DistortionModel::kEquidistant:
      result.distortion = mrpt::img::DistortionModel::kannala_brandt;
      result.k1(camera.coefficients[0]);
      result.k2(camera.coefficients[1]);
      result.k3(camera.coefficients[2]);
      result.k4(camera.coefficients[3]);
      break;
  }
  return result;
}

}  // namespace edge_mcl
