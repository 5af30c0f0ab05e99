// Tests that calibrations of many tools are read. The truth is what their documents say each key
// means, and OpenCV's projection for the distortion.
#include <gtest/gtest.h>

#include <fstream>
#include <opencv2/calib3d.hpp>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/camera/camera_model.h"
#include "support/error_text.h"

namespace edge_mcl {
namespace {

const std::string kRosHead = "image_width: 320\nimage_height: 240\ncamera_name: c\n";

std::string matrix(const std::string& numbers, const std::string& tag = "") {
  return "camera_matrix:" + tag + "\n  rows: 3\n  cols: 3\n  data: [" + numbers + "]\n";
}

std::string coefficients(const std::string& numbers, const std::string& tag = "") {
  return "distortion_coefficients:" + tag + "\n  data: [" + numbers + "]\n";
}

const std::string kMatrix = "215, 0, 161, 0, 214, 119, 0, 0, 1";

std::string write(const std::string& text) {
  std::string file = testing::TempDir() + "calibration_test.yaml";
  std::ofstream(file) << text;
  return file;
}

CameraModel read(const std::string& text, const std::string& name = "") {
  return CameraModel::fromYamlFile(write(text) + name);
}

std::string errorOf(const std::string& text, const std::string& name = "") {
  return test::errorText<InputError>([&] { read(text, name); });
}

/// The pixel of a point 1 m ahead at (0.3, -0.2) m by OpenCV.
cv::Point2d projected(const std::vector<double>& d, bool fisheye) {
  const cv::Matx33d k(215, 0, 161, 0, 214, 119, 0, 0, 1);
  const std::vector<cv::Point3d> points{{0.3, -0.2, 1}};
  std::vector<cv::Point2d> pixel;
  const cv::Vec3d zero(0, 0, 0);
  if (fisheye)
    cv::fisheye::projectPoints(points, pixel, zero, zero, k, d);
  else
    cv::projectPoints(points, zero, zero, k, d, pixel);
  return pixel[0];
}

void expectCamera(const CameraModel& camera, const std::vector<double>& d, bool fisheye) {
  EXPECT_EQ(camera.width, 320);
  EXPECT_EQ(camera.height, 240);
  Eigen::Vector2d pixel;
  ASSERT_TRUE(camera.project({0.3, -0.2, 1}, &pixel));
  const cv::Point2d truth = projected(d, fisheye);
  EXPECT_NEAR(pixel.x(), truth.x, 1e-9);
  EXPECT_NEAR(pixel.y(), truth.y, 1e-9);
}

TEST(Calibration, RosNamesOfAllDrivers) {
  const std::string plumb = "-0.12, 0.03, 0.0004, -0.0003, 0.01";
  for (const char* name : {"plumb_bob", "radtan", "radial-tangential", "Brown-Conrady"})
    expectCamera(
        read(kRosHead + matrix(kMatrix) + coefficients(plumb) + "distortion_model: " + name + "\n"),
        {-0.12, 0.03, 0.0004, -0.0003, 0.01}, false);
  for (const char* name : {"equidistant", "fisheye", "Kannala_Brandt4"})
    expectCamera(read(kRosHead + matrix(kMatrix) + coefficients("-0.02, 0.01, 0.001, 0") +
                      "distortion_model: " + name + "\n"),
                 {-0.02, 0.01, 0.001, 0}, true);
}

TEST(Calibration, TheNumberOfCoefficientsDecidesAmongTheModelsOfOpenCv) {
  const std::vector<double> eight{0.1, -0.2, 0.001, 0.002, 0.1, 0.1, -0.1, 0.05};
  const std::string list = "0.1, -0.2, 0.001, 0.002, 0.1, 0.1, -0.1, 0.05";
  for (const char* model :
       {"distortion_model: plumb_bob\n", "distortion_model: rational_polynomial\n",
        "camera_model: plumb_bob\n", ""})
    for (const char* more : {"", ", 0, 0, 0, 0, 0, 0"})
      expectCamera(read(kRosHead + matrix(kMatrix) + coefficients(list + more) + model), eight,
                   false);
  expectCamera(
      read(kRosHead + matrix(kMatrix) + coefficients("") + "distortion_model: plumb_bob\n"), {},
      false);
  const std::string error =
      errorOf(kRosHead + matrix(kMatrix) + coefficients(list + ", 0.001, 0, 0, 0, 0, 0") +
              "distortion_model: rational_polynomial\n");
  EXPECT_NE(error.find("image_proc"), std::string::npos) << error;
}

TEST(Calibration, OpenCvFile) {
  const std::string tag = " !!opencv-matrix";
  expectCamera(read("%YAML:1.0\n---\ncalibration_time: \"Mon\"\n" + kRosHead +
                    matrix(kMatrix, tag) + coefficients("-0.12, 0.03, 0.0004, -0.0003, 0.", tag)),
               {-0.12, 0.03, 0.0004, -0.0003, 0}, false);
  expectCamera(read("%YAML:1.0\n---\nfisheye_model: 1\n" + kRosHead + matrix(kMatrix, tag) +
                    coefficients("-0.02, 0.01, 0.001, 0.", tag)),
               {-0.02, 0.01, 0.001, 0}, true);
}

std::string chain(const std::string& name, const std::string& model) {
  return name +
         ":\n  camera_model: pinhole\n  distortion_coeffs: [-0.02, 0.01, 0.001, 0.0]\n"
         "  distortion_model: " +
         model + "\n  intrinsics: [215.0, 214.0, 161.0, 119.0]\n  resolution: [320, 240]\n";
}

TEST(Calibration, KalibrChain) {
  expectCamera(read(chain("cam0", "equidistant")), {-0.02, 0.01, 0.001, 0}, true);
  const std::string two = chain("cam0", "equidistant") + chain("cam1", "radtan");
  expectCamera(read(two, ":cam1"), {-0.02, 0.01, 0.001, 0}, false);
  EXPECT_NE(errorOf(two).find("calibration_test.yaml:cam1"), std::string::npos) << errorOf(two);
  EXPECT_NE(errorOf(two, ":cam7").find("'cam7'"), std::string::npos) << errorOf(two, ":cam7");
  EXPECT_NE(errorOf(chain("cam0", "fov")).find("'fov'"), std::string::npos);
  const std::string omni = "cam0: {camera_model: omni, intrinsics: [1, 2, 3, 4, 5]}\n";
  EXPECT_NE(errorOf(omni).find("'omni'"), std::string::npos) << errorOf(omni);
}

TEST(Calibration, EurocSensorFile) {
  expectCamera(read("sensor_type: camera\nresolution: [320, 240]\ncamera_model: pinhole\n"
                    "intrinsics: [215, 214, 161, 119] #fu, fv, cu, cv\n"
                    "distortion_model: radial-tangential\n"
                    "distortion_coefficients: [-0.12, 0.03, 0.0004, -0.0003]\n"),
               {-0.12, 0.03, 0.0004, -0.0003}, false);
}

TEST(Calibration, OrbSlamFiles) {
  const std::string size = "Camera.width: 320\nCamera.height: 240\n";
  for (const std::string prefix : {"Camera.", "Camera1."}) {
    const auto key = [&](const char* name, const char* value) {
      std::string line = prefix;
      return line.append(name).append(": ").append(value).append("\n");
    };
    std::string pinhole;
    for (const auto& [name, value] : {std::pair{"fx", "215.0"}, std::pair{"fy", "214.0"},
                                      std::pair{"cx", "161.0"}, std::pair{"cy", "119.0"}})
      pinhole += key(name, value);
    const std::string k1 = key("k1", "-0.12") + key("k2", "0.03");
    std::string plain = "%YAML:1.0\n";
    plain.append(size).append(pinhole).append(k1);
    plain.append(key("p1", "0.0004")).append(key("p2", "-0.0003"));
    expectCamera(read(plain), {-0.12, 0.03, 0.0004, -0.0003}, false);
    std::string fisheye = "%YAML:1.0\n---\nCamera.type: \"KannalaBrandt8\"\n";
    fisheye.append(size).append(pinhole).append(k1);
    fisheye.append(key("k3", "0.001")).append(key("k4", "0"));
    expectCamera(read(fisheye), {-0.12, 0.03, 0.001, 0}, true);
    EXPECT_NE(errorOf("%YAML:1.0\n" + pinhole).find("Camera.width"), std::string::npos);
  }
}

TEST(Calibration, VinsFiles) {
  const std::string size = "image_width: 320\nimage_height: 240\n";
  expectCamera(read("%YAML:1.0\n---\nmodel_type: PINHOLE\n" + size +
                    "distortion_parameters:\n  k1: -0.12\n  k2: 0.03\n  p1: 0.0004\n  p2: -0.0003\n"
                    "projection_parameters:\n  fx: 215\n  fy: 214\n  cx: 161\n  cy: 119\n"),
               {-0.12, 0.03, 0.0004, -0.0003}, false);
  expectCamera(read("%YAML:1.0\n---\nmodel_type: KANNALA_BRANDT\n" + size +
                    "projection_parameters:\n  k2: -0.02\n  k3: 0.01\n  k4: 0.001\n  k5: 0\n"
                    "  mu: 215\n  mv: 214\n  u0: 161\n  v0: 119\n"),
               {-0.02, 0.01, 0.001, 0}, true);
}

TEST(Calibration, AnUncalibratedCameraIsToldAsSuch) {
  const std::string error =
      errorOf(kRosHead + matrix("0, 0, 0, 0, 0, 0, 0, 0, 0") + coefficients("0, 0, 0, 0, 0") +
              "distortion_model: plumb_bob\n");
  EXPECT_NE(error.find("not calibrated"), std::string::npos) << error;
}

/// A skew of 0.43 px moves a pixel at the border by 0.43 * 121 / 214 = 0.24 px.
TEST(Calibration, ASmallSkewIsLeftOutAndALargeOneIsRefused) {
  const auto file = [](const std::string& skew) {
    return kRosHead + matrix("215, " + skew + ", 161, 0, 214, 119, 0, 0, 1") +
           coefficients("-0.02, 0.01, 0.001, 0") + "distortion_model: equidistant\n";
  };
  expectCamera(read(file("0.43")), {-0.02, 0.01, 0.001, 0}, true);
  EXPECT_NE(errorOf(file("5")).find("skew"), std::string::npos) << errorOf(file("5"));
}

TEST(Calibration, OtherFilesAreRefusedByName) {
  EXPECT_NE(errorOf("a: 1\n").find("Kalibr"), std::string::npos) << errorOf("a: 1\n");
  EXPECT_NE(errorOf(kRosHead + "camera_matrix: 5\n").find("wrong kind"), std::string::npos);
  EXPECT_NE(errorOf("- 1\n- 2\n").find("camera_matrix"), std::string::npos);
}

}  // namespace
}  // namespace edge_mcl
