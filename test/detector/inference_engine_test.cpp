// Engines that run a network, against each other and against networks whose results are known.
#include "edge_mcl/detector/inference_engine.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <opencv2/imgproc.hpp>
#include <string>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/detector/default_model.h"
#include "edge_mcl/detector/mask_detector.h"
#include "support/temporary_folder.h"

namespace edge_mcl {
namespace {

constexpr int kSize = 8;

// Fields of a protocol buffer, as onnx.proto numbers them.
std::string varint(uint64_t value) {
  std::string bytes;
  for (; value >= 128; value >>= 7) bytes += static_cast<char>(value | 128);
  return bytes + static_cast<char>(value);
}
std::string field(int number, uint64_t value) {
  return varint(static_cast<uint64_t>(number) << 3) + varint(value);
}
std::string field(int number, const std::string& value) {
  return varint(static_cast<uint64_t>(number) << 3 | 2) + varint(value.size()) + value;
}

/// An image of a network. @param type 1: float, 10: half precision
std::string imageField(int number, const std::string& name, uint64_t type) {
  std::string shape;
  for (const int n : {1, 3, kSize, kSize}) shape += field(1, field(1, static_cast<uint64_t>(n)));
  const std::string tensor = field(1, type) + field(2, shape);
  return field(number, field(1, name) + field(2, field(1, tensor)));
}

/// A network of one layer without parameters. Its input and output are images of three channels.
DetectorModel networkOf(const std::string& folder, const std::string& layer, uint64_t type) {
  const std::string node =
      field(1, std::string("in")) + field(2, std::string("out")) + field(4, layer);
  const std::string graph = field(1, node) + field(2, std::string("graph")) +
                            imageField(11, "in", type) + imageField(12, "out", type);
  const std::string version = field(1, std::string()) + field(2, uint64_t{13});
  DetectorModel model;
  model.name = layer;
  model.file = folder + "/" + layer + ".onnx";
  std::ofstream(model.file, std::ios::binary)
      << field(1, uint64_t{7}) + field(7, graph) + field(8, version);
  model.width = model.height = kSize;
  model.classes = {"background", "one", "two"};
  model.movable = {"one"};
  return model;
}

DetectorParameters with(const std::string& engine) {
  DetectorParameters parameters;
  parameters.set("engine", engine);
  return parameters;
}

cv::Mat noise() {
  cv::Mat image(kSize, kSize, CV_8UC3);
  cv::theRNG().state = 7;
  cv::randu(image, 0, 255);
  return image;
}

using InferenceEngineTest = test::WithFolder;

TEST_F(InferenceEngineTest, OpenCvRunsWhatItKnows) {
  MaskDetector detector(networkOf(path(""), "Relu", 1), with("auto"));
  EXPECT_STREQ(detector.engine(), "opencv");
  EXPECT_EQ(detector.rawOutputs(noise()).at(0).at<float>(5), noise().at<cv::Vec3b>(0, 5)[0]);
}

TEST_F(InferenceEngineTest, WithoutOnnxRuntimeTheErrorNamesIt) {
  if (hasOnnxRuntime()) GTEST_SKIP() << "this build has ONNX Runtime";
  try {
    const MaskDetector detector(networkOf(path(""), "Relu", 1), with("onnxruntime"));
    FAIL();
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find("no ONNX Runtime"), std::string::npos) << e.what();
  }
  // OpenCV does not know this layer.
  EXPECT_THROW(MaskDetector(networkOf(path(""), "Hardmax", 1), with("auto")), InputError);
}

class OnnxRuntime : public test::WithFolder {
  void SetUp() override {
    if (!hasOnnxRuntime()) GTEST_SKIP() << "this build has no ONNX Runtime";
  }
};

/// Two implementations that know nothing of each other.
TEST_F(OnnxRuntime, GivesTheNumbersOfOpenCv) {
  const DetectorModel model = DetectorModel::fromYamlFile(defaultModelFile());
  MaskDetector one(model, with("opencv")), other(model, with("onnxruntime"));
  cv::Mat image;
  cv::resize(noise(), image, cv::Size(model.width, model.height), 0, 0, cv::INTER_LINEAR);
  const cv::Mat a = one.rawOutputs(image).at(0), b = other.rawOutputs(image).at(0);
  ASSERT_EQ(a.total(), b.total());
  // Single precision, over some thirty layers.
  EXPECT_LT(cv::norm(a, b, cv::NORM_INF), 1e-3 * cv::norm(a, cv::NORM_INF));
}

TEST_F(OnnxRuntime, RunsALayerThatOpenCvDoesNotKnow) {
  MaskDetector detector(networkOf(path(""), "Hardmax", 1), with("auto"));
  EXPECT_STREQ(detector.engine(), "onnxruntime");
  const cv::Mat image = noise(), found = detector.rawOutputs(image).at(0);
  for (int row = 0; row < kSize; ++row) {
    int highest = 0;
    for (int x = 1; x < kSize; ++x)
      if (image.at<cv::Vec3b>(row, x)[0] > image.at<cv::Vec3b>(row, highest)[0]) highest = x;
    for (int x = 0; x < kSize; ++x)
      EXPECT_EQ(found.at<float>(row * kSize + x), x == highest ? 1 : 0);
  }
}

TEST_F(OnnxRuntime, RunsHalfPrecision) {
  MaskDetector detector(networkOf(path(""), "Relu", 10), with("onnxruntime"));
  // Whole numbers up to 2048 are exact in half precision.
  EXPECT_EQ(detector.rawOutputs(noise()).at(0).at<float>(5), noise().at<cv::Vec3b>(0, 5)[0]);
}

TEST_F(OnnxRuntime, ABrokenFileIsOneError) {
  DetectorModel model = networkOf(path(""), "Relu", 1);
  std::ofstream(model.file, std::ios::binary) << "no network";
  EXPECT_THROW(MaskDetector(model, with("onnxruntime")), InputError);
  EXPECT_THROW(MaskDetector(model, with("auto")), InputError);
}

}  // namespace
}  // namespace edge_mcl
