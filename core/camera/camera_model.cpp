#include "edge_mcl/core/camera/camera_model.h"

#include <algorithm>
#include <cmath>

#include "edge_mcl/core/base/error.h"

namespace edge_mcl {

namespace {

struct Radial {
  double factor;      // multiplies (x, y)
  double derivative;  // d factor / d r2
};

Radial radialFactor(const CameraModel& camera, double r2) {
  const auto& c = camera.coefficients;
  const double r4 = r2 * r2, r6 = r4 * r2;
  const double num = 1 + c[0] * r2 + c[1] * r4 + c[4] * r6;
  const double num_d = c[0] + 2 * c[1] * r2 + 3 * c[4] * r4;
  if (camera.distortion != DistortionModel::kRationalPolynomial) return {num, num_d};
  const double den = 1 + c[5] * r2 + c[6] * r4 + c[7] * r6;
  const double den_d = c[5] + 2 * c[6] * r2 + 3 * c[7] * r4;
  return {num / den, (num_d * den - num * den_d) / (den * den)};
}

/// Distorted angle theta_d and its derivative by theta.
Radial equidistantAngle(const CameraModel& camera, double theta) {
  const auto& k = camera.coefficients;
  const double t2 = theta * theta;
  const double value = theta * (1 + t2 * (k[0] + t2 * (k[1] + t2 * (k[2] + t2 * k[3]))));
  const double slope = 1 + t2 * (3 * k[0] + t2 * (5 * k[1] + t2 * (7 * k[2] + t2 * 9 * k[3])));
  return {value, slope};
}

/// Largest angle to the optical axis at which points are projected, radians. It is just below 90
/// degrees.
constexpr double kWidest = 1.55;

/// Square of the first radius (equidistant: angle) at which the distorted radius stops growing.
double monotoneLimit2(const CameraModel& camera) {
  constexpr double kStep = 1e-3;
  if (camera.distortion == DistortionModel::kNone) return 1e12;
  if (camera.distortion == DistortionModel::kEquidistant) {
    double theta = kStep;
    for (; theta < kWidest; theta += kStep)
      if (equidistantAngle(camera, theta).derivative <= 0) break;
    return theta * theta;
  }
  for (double r = kStep; r < 20; r += kStep) {
    const Radial f = radialFactor(camera, r * r);
    // The factor is checked, too: beyond a pole of the rational model the radius also grows, but on
    // the other side of the image.
    if (!(f.factor > 0 && f.factor + 2 * r * r * f.derivative > 0)) return r * r;
  }
  return 400;
}

/// Angle to the optical axis of the ray that has a given distorted normalised radius, by bisection.
/// Tangential distortion is not considered.
double undistortedAngle(const CameraModel& camera, double distorted_radius) {
  double low = 0, high = kWidest;
  for (int i = 0; i < 50; ++i) {
    const double angle = 0.5 * (low + high), r = std::tan(angle);
    double reached = 0;
    bool beyond = false;
    if (camera.distortion == DistortionModel::kEquidistant) {
      beyond = angle * angle > camera.max_radius2;
      reached = equidistantAngle(camera, angle).factor;
    } else {
      beyond = r * r > camera.max_radius2;
      reached = r * radialFactor(camera, r * r).factor;
    }
    (beyond || reached > distorted_radius ? high : low) = angle;
  }
  return high;
}

/// Bounds of the view, from rays along the whole border of the image.
CameraModel::View viewOf(const CameraModel& camera) {
  CameraModel::View view{0, 0, 0, 0, 0};
  const auto add = [&](double u, double v) {
    const double tx = (u - camera.cx) / camera.fx, ty = (v - camera.cy) / camera.fy;
    const double radius = std::max(1e-9, std::hypot(tx, ty));
    // Tangential distortion shifts a corner by a few pixels. One degree covers it.
    const double angle = std::min(undistortedAngle(camera, radius) + 0.02, 1.57);
    const double x = tx / radius * std::tan(angle), y = ty / radius * std::tan(angle);
    view.angle = std::max(view.angle, angle);
    view.x_min = std::min(view.x_min, x - 0.02);
    view.x_max = std::max(view.x_max, x + 0.02);
    view.y_min = std::min(view.y_min, y - 0.02);
    view.y_max = std::max(view.y_max, y + 0.02);
  };
  constexpr int kRays = 32;  // per side of the image
  for (int i = 0; i <= kRays; ++i) {
    const double u = (camera.width - 1.0) * i / kRays, v = (camera.height - 1.0) * i / kRays;
    add(u, 0);
    add(u, camera.height - 1.0);
    add(0, v);
    add(camera.width - 1.0, v);
  }
  return view;
}

}  // namespace

void CameraModel::validate(const std::string& origin) {
  std::string faults;
  const auto fault = [&](const std::string& text) {
    faults += (faults.empty() ? "" : "; ") + text;
  };
  if (width <= 0 || height <= 0 || width > 20000 || height > 20000)
    fault("image size must be positive and at most 20000");
  if (!(fx > 0) || !(fy > 0) || !std::isfinite(fx) || !std::isfinite(fy))
    fault("fx and fy must be positive");
  if (!std::isfinite(cx) || !std::isfinite(cy)) fault("cx and cy must be finite");
  for (double c : coefficients)
    if (!std::isfinite(c)) {
      fault("distortion coefficients must be finite");
      break;
    }
  if (!faults.empty()) throw InputError(origin + ": " + faults);
  bool zero = true;
  for (double c : coefficients) zero = zero && c == 0;
  if (zero && distortion != DistortionModel::kEquidistant) distortion = DistortionModel::kNone;
  max_radius2 = monotoneLimit2(*this);
  view = viewOf(*this);
}

double CameraModel::maxPlaneRadius2() const {
  if (distortion != DistortionModel::kEquidistant) return max_radius2;
  return std::pow(std::tan(std::min(std::sqrt(max_radius2), 1.57)), 2);
}

bool CameraModel::project(const Eigen::Vector3d& point, Eigen::Vector2d* pixel,
                          Eigen::Matrix<double, 2, 3>* jacobian) const {
  if (!(point.z() > kMinDepth)) return false;
  const double iz = 1 / point.z();
  const double x = point.x() * iz, y = point.y() * iz, r2 = x * x + y * y;
  double xd = x, yd = y;
  // d(xd, yd) / d(x, y)
  double j00 = 1, j01 = 0, j10 = 0, j11 = 1;
  if (distortion == DistortionModel::kEquidistant) {
    const double r = std::sqrt(r2);
    if (r > 1e-8) {
      const double theta = std::atan(r);
      if (theta * theta > max_radius2) return false;
      const Radial a = equidistantAngle(*this, theta);
      const double scale = a.factor / r;
      const double radial_slope = a.derivative / (1 + r2);  // d theta_d / d r
      const double s = (radial_slope - scale) / r2;
      xd = x * scale;
      yd = y * scale;
      j00 = scale + s * x * x;
      j01 = j10 = s * x * y;
      j11 = scale + s * y * y;
    }
  } else if (distortion != DistortionModel::kNone) {
    if (r2 > max_radius2) return false;
    const Radial f = radialFactor(*this, r2);
    const double p1 = coefficients[2], p2 = coefficients[3];
    xd = x * f.factor + 2 * p1 * x * y + p2 * (r2 + 2 * x * x);
    yd = y * f.factor + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y;
    j00 = f.factor + 2 * x * x * f.derivative + 2 * p1 * y + 6 * p2 * x;
    j01 = 2 * x * y * f.derivative + 2 * p1 * x + 2 * p2 * y;
    j10 = j01;
    j11 = f.factor + 2 * y * y * f.derivative + 6 * p1 * y + 2 * p2 * x;
  }
  *pixel = {fx * xd + cx, fy * yd + cy};
  if (jacobian) {
    Eigen::Matrix<double, 2, 3> normalized;
    normalized << iz, 0, -x * iz, 0, iz, -y * iz;
    Eigen::Matrix2d d;
    d << fx * j00, fx * j01, fy * j10, fy * j11;
    *jacobian = d * normalized;
  }
  return true;
}

}  // namespace edge_mcl
