// Makes a camera from the fields that calibration tools and drivers write.
#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdio>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/camera/camera_model.h"

namespace edge_mcl {

namespace {

/// What to do with a camera whose distortion is not known here.
constexpr const char* kWayOn =
    "calibrate it with plumb_bob, rational_polynomial or equidistant, or use rectified images "
    "(image_proc) and their calibration";

/// A name in small letters without signs, since tools write "radial-tangential",
/// "Radial_Tangential" and so on.
std::string plainName(const std::string& name) {
  std::string plain;
  for (const char c : name)
    if (std::isalnum(static_cast<unsigned char>(c)))
      plain += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return plain;
}

bool isOneOf(const std::string& name, std::initializer_list<const char*> names) {
  return std::any_of(names.begin(), names.end(), [&](const char* n) { return name == n; });
}

/// Number of coefficients without the zeros at the end.
size_t usedCount(const double* d, size_t size) {
  while (size > 0 && d[size - 1] == 0) --size;
  return size;
}

/// The model of a name. @param used number of coefficients.
DistortionModel modelOf(const std::string& name, size_t used, const std::string& origin) {
  const std::string plain = plainName(name);
  // OpenCV's models differ by their number of coefficients only, and so do the files of its users.
  constexpr size_t kPlumbBob = 5;
  if (isOneOf(plain, {"", "plumbbob", "radtan", "radialtangential", "brownconrady",
                      "rationalpolynomial", "rational", "opencv"}))
    return used > kPlumbBob || isOneOf(plain, {"rationalpolynomial", "rational"})
               ? DistortionModel::kRationalPolynomial
               : DistortionModel::kPlumbBob;
  if (isOneOf(plain, {"equidistant", "equi", "fisheye", "opencvfisheye", "kannalabrandt",
                      "kannalabrandt4", "kannalabrandt8"}))
    return DistortionModel::kEquidistant;
  if (isOneOf(plain, {"none", "pinhole"})) return DistortionModel::kNone;
  throw InputError(origin + ": distortion_model '" + name + "' is not supported; " + kWayOn);
}

size_t coefficientsOf(DistortionModel model) {
  switch (model) {
    case DistortionModel::kNone:
      return 0;
    case DistortionModel::kPlumbBob:
      return 5;
    case DistortionModel::kRationalPolynomial:
      return 8;
    case DistortionModel::kEquidistant:
      return 4;
  }
  return 0;
}

/// @throws InputError when the skew moves a pixel farther than edges are found.
void checkSkew(double skew, const CameraModel& camera, const std::string& origin) {
  constexpr double kUnseen = 0.5;  // px, less than the noise of an image edge
  const double height = std::max(camera.cy, camera.height - camera.cy) / camera.fy;
  const double moved = std::abs(skew * height);
  if (moved <= kUnseen) return;
  char text[160];
  std::snprintf(text, sizeof text,
                ": the skew of the camera matrix (%.3g) moves pixels by up to %.1f px and is not "
                "supported; ",
                skew, moved);
  throw InputError(origin + text +
                   "calibrate without skew, or use rectified images (image_proc) "
                   "and their calibration");
}

}  // namespace

CameraModel CameraModel::fromFields(int width, int height, const std::array<double, 9>& k,
                                    const std::string& distortion_model, const double* d,
                                    size_t d_size, const std::string& origin) {
  if (std::all_of(k.begin(), k.begin() + 6, [](double v) { return v == 0; }))
    throw InputError(origin +
                     ": the camera is not calibrated (its camera matrix is zero); calibrate it "
                     "with `rosrun camera_calibration cameracalibrator.py`");
  CameraModel camera;
  camera.width = width;
  camera.height = height;
  camera.fx = k[0];
  camera.fy = k[4];
  camera.cx = k[2];
  camera.cy = k[5];
  const size_t used = usedCount(d, d_size);
  camera.distortion = modelOf(distortion_model, used, origin);
  const size_t most = coefficientsOf(camera.distortion);
  if (used > most)
    throw InputError(origin + ": " + std::to_string(used) + " distortion coefficients are given, " +
                     (distortion_model.empty() ? "OpenCV's model" : distortion_model) +
                     " is supported with " + std::to_string(most) + "; " + kWayOn);
  std::copy_n(d, used, camera.coefficients.begin());
  if (k[3] != 0 || k[6] != 0 || k[7] != 0 || k[8] != 1)
    throw InputError(origin + ": the camera matrix must have the rows fx 0 cx, 0 fy cy, 0 0 1");
  camera.validate(origin);
  checkSkew(k[1], camera, origin);
  return camera;
}

}  // namespace edge_mcl
