// Descriptions of networks, parameters, and what is wrong with them.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "edge_mcl/core/error.h"
#include "edge_mcl/detector/default_model.h"
#include "edge_mcl/detector/detector_model.h"
#include "edge_mcl/detector/mask_detector.h"

namespace edge_mcl {
namespace {

namespace fs = std::filesystem;

class DetectorModelFile : public ::testing::Test {
 protected:
  void SetUp() override {
    directory_ = fs::temp_directory_path() /
                 (std::string("edge_mcl_") +
                  ::testing::UnitTest::GetInstance()->current_test_info()->name());
    fs::create_directories(directory_);
  }
  void TearDown() override { fs::remove_all(directory_); }
  std::string write(const std::string& name, const std::string& text) const {
    std::string file = (directory_ / name).string();
    std::ofstream(file) << text;
    return file;
  }
  static std::string faultOf(const std::string& file) {
    try {
      DetectorModel::fromYamlFile(file);
    } catch (const InputError& e) {
      return e.what();
    }
    return "";
  }
  fs::path directory_;
};

TEST_F(DetectorModelFile, AllFaultsAtOnce) {
  const std::string fault = faultOf(
      write("m.yaml",
            "fille: a\nwidth: 2\nlayout: yolo9\ncolors: cmyk\nclasses: [a, b]\nmovable: [c]\n"));
  for (const char* part : {"'fille' (nearest: 'file')", "'file' is missing", "width and height",
                           "layout must be one of", "yolox", "colors must be", "'c' is not among"})
    EXPECT_NE(fault.find(part), std::string::npos) << part << " in " << fault;
}

TEST_F(DetectorModelFile, ValuesOfTheWrongKind) {
  EXPECT_NE(faultOf(write("m.yaml", "file: a\nwidth: wide\nclasses: [a]\n")).find("'width'"),
            std::string::npos);
  EXPECT_NE(faultOf(write("m.yaml", "file: a\nmean: [1, 2]\nclasses: [a]\n")).find("'mean'"),
            std::string::npos);
  EXPECT_NE(faultOf(write("m.yaml", "just text")).find("keys and values"), std::string::npos);
  EXPECT_NE(faultOf((directory_ / "none.yaml").string()).find("cannot be read"), std::string::npos);
}

TEST_F(DetectorModelFile, FilesLieBesideTheDescription) {
  const DetectorModel m = DetectorModel::fromYamlFile(write(
      "m.yaml", "file: sub/a.onnx\nclasses: [a, b]\nscale: 2\nlayout: yolo\nfit: letterbox\n"));
  EXPECT_EQ(m.file, (directory_ / "sub/a.onnx").string());
  EXPECT_EQ(m.name, "m");
  EXPECT_EQ(m.scale, (std::array<double, 3>{2, 2, 2}));
  EXPECT_EQ(m.fit, InputFit::kLetterbox);
  EXPECT_EQ(m.classNumber("b"), 1);
  EXPECT_THROW(m.classNumber("bb"), ParameterError);
}

TEST_F(DetectorModelFile, BrokenNetworksAreOneClearError) {
  const std::string text = "file: a.onnx\nclasses: [background, a]\nmovable: [a]\n";
  const DetectorModel model = DetectorModel::fromYamlFile(write("m.yaml", text));
  EXPECT_THROW(MaskDetector(model, {}), InputError) << "missing";
  write("a.onnx", "this is no network");
  EXPECT_THROW(MaskDetector(model, {}), InputError) << "garbage";
  write("a.onnx", "");
  EXPECT_THROW(MaskDetector(model, {}), InputError) << "empty";
}

TEST_F(DetectorModelFile, ATruncatedNetwork) {
  const DetectorModel whole = DetectorModel::fromYamlFile(defaultModelFile());
  fs::copy_file(whole.file, directory_ / "a.onnx");
  fs::resize_file(directory_ / "a.onnx", fs::file_size(whole.file) / 2);
  DetectorModel half = whole;
  half.file = (directory_ / "a.onnx").string();
  EXPECT_THROW(MaskDetector(half, {}), InputError);
}

TEST(EmbeddedModel, WrongDescriptionsAreTold) {
  DetectorModel model = DetectorModel::fromYamlFile(defaultModelFile());
  DetectorModel fewer = model;
  fewer.classes.pop_back();
  fewer.movable.pop_back();
  EXPECT_THROW(MaskDetector(fewer, {}), InputError) << "another number of classes";
  DetectorModel other = model;
  other.layout = OutputLayout::kYolox;
  EXPECT_THROW(MaskDetector(other, {}), InputError) << "another layout";
  DetectorParameters unknown;
  unknown.ignore_classes = "person, sofaa";
  try {
    const MaskDetector detector(model, unknown);
    ADD_FAILURE() << "accepted";
  } catch (const ParameterError& e) {
    EXPECT_NE(std::string(e.what()).find("nearest: 'sofa'"), std::string::npos) << e.what();
  }
}

TEST(EmbeddedModel, TakesAnySizeAndGrey) {
  MaskDetector detector(DetectorModel::fromYamlFile(defaultModelFile()), {});
  for (const cv::Size size : {cv::Size(640, 480), cv::Size(123, 77), cv::Size(1, 1)})
    for (const int type : {CV_8UC3, CV_8UC1})
      for (const Detection& d : detector.detect(cv::Mat(size, type, cv::Scalar::all(90))))
        EXPECT_EQ(d.mask.size(), size);
  EXPECT_THROW(detector.detect(cv::Mat()), InputError);
  EXPECT_THROW(detector.detect(cv::Mat(10, 10, CV_32FC3)), InputError);
}

TEST(DetectorParameters, AllFaultsAndNearMisses) {
  DetectorParameters p;
  EXPECT_NO_THROW(p.validate());
  p.half_life = 0;
  p.nms_threshold = 2;
  EXPECT_EQ(p.faults().size(), 2u);
  EXPECT_THROW(p.validate(), ParameterError);
  DetectorParameters q;
  q.set("dilation", "7");
  EXPECT_EQ(q.dilation, 7);
  EXPECT_THROW(q.set("dilation", "wide"), ParameterError);
  EXPECT_THROW(q.set("dilatoin", "7"), ParameterError);
}

}  // namespace
}  // namespace edge_mcl
