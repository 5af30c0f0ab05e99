// Tests descriptions of networks, parameters, and the messages about their faults.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <opencv2/imgproc.hpp>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/base/parameter_struct.h"
#include "edge_mcl/detector/default_model.h"
#include "edge_mcl/detector/detector_model.h"
#include "edge_mcl/detector/mask_detector.h"
#include "edge_mcl/detector/recorded_flight_masks.h"

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
  /// A network whose scores of three classes are the blue, green and red of the image.
  DetectorModel colorNetwork(const std::string& classes,
                             const std::string& layer = "type: \"ReLU\"") const {
    write("colors.prototxt",
          "input: \"data\"\ninput_shape { dim: 1 dim: 3 dim: 24 dim: 32 }\n"
          "layer { name: \"scores\" bottom: \"data\" top: \"scores\" " +
              layer + " }\n");
    return DetectorModel::fromYamlFile(
        write("colors.yaml",
              "file: colors.prototxt\nwidth: 32\nheight: 24\nmovable: [chair]\n"
              "classes: " +
                  classes + "\n"));
  }
  fs::path directory_;
};

const cv::Scalar kBlue(255, 0, 0), kGreen(0, 255, 0), kRed(0, 0, 255);

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

TEST_F(DetectorModelFile, NumbersAndKeysThatAreNone) {
  const std::string text = "file: a\nclasses: [a]\n";
  const std::string fault =
      faultOf(write("m.yaml", text + "scale: 0\nmean: .nan\npadding: .inf\n? [1, 2]\n: 3\n"));
  for (const char* part :
       {"scale must be", "mean must be", "padding must be", "a key is not a plain name"})
    EXPECT_NE(fault.find(part), std::string::npos) << part << " in " << fault;
  EXPECT_NE(faultOf(write("m.yaml", text + "scale: [1, 1, .inf]\n")).find("scale must be"),
            std::string::npos);
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
  DetectorModel unnameable = model;
  unnameable.file = std::string(300, 'a');  // no file can have a name of this length
  EXPECT_THROW(MaskDetector(unnameable, {}), InputError) << "a name that is too long";
}

/// Two classes have the name chair. Objects of both must be found.
TEST_F(DetectorModelFile, ClassesOfOneNameAreAllIgnored) {
  MaskDetector detector(colorNetwork("[wall, chair, chair]"), {});
  cv::Mat image(48, 64, CV_8UC3, kBlue);
  image(cv::Rect(8, 8, 16, 16)) = kGreen;
  image(cv::Rect(40, 24, 16, 16)) = kRed;
  EXPECT_EQ(detector.detect(image).size(), 2u);
}

TEST_F(DetectorModelFile, AnOutputThatIsNotFiniteIsAnError) {
  // The output is the square root of 200 - colour, which is not finite for white.
  MaskDetector detector(
      colorNetwork("[wall, table, chair]",
                   "type: \"Power\" power_param { power: 0.5 scale: -1 shift: 200 }"),
      {});
  EXPECT_NO_THROW(detector.detect(cv::Mat(24, 32, CV_8UC3, cv::Scalar::all(100))));
  try {
    detector.detect(cv::Mat(24, 32, CV_8UC3, cv::Scalar::all(255)));
    ADD_FAILURE() << "accepted";
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find("not finite"), std::string::npos) << e.what();
  }
}

TEST_F(DetectorModelFile, AResultThatComesManyImagesLateIsUsed) {
  DetectorParameters parameters;
  parameters.min_confidence = 0;  // the image has no corners to follow
  MaskDetector detector(colorNetwork("[wall, table, chair]"), parameters);
  RecordedFlightMasks flight(&detector, parameters, 1, 5);
  cv::Mat image(48, 64, CV_8UC3, kBlue), larger;
  image(cv::Rect(16, 16, 24, 16)) = kRed;
  for (int i = 0; i <= 7 * 15; ++i) flight.next(image, i / 15.0);
  // The second run of the network began at 1 s. Its result comes 75 images later.
  ASSERT_EQ(flight.tracker().objects().size(), 1u);
  EXPECT_NEAR(flight.tracker().objects()[0].age, 6, 0.1);
  // With an image of another size the tracker knows no object, so it waits for the result.
  cv::resize(image, larger, {}, 2, 2);
  flight.next(larger, 7.1);
  ASSERT_EQ(flight.tracker().objects().size(), 1u);
  EXPECT_EQ(flight.tracker().objects()[0].age, 0);
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
  EXPECT_EQ(parameterFaults(p).size(), 2u);
  EXPECT_THROW(p.validate(), ParameterError);
  DetectorParameters q;
  q.set("dilation", "7");
  EXPECT_EQ(q.dilation, 7);
  EXPECT_THROW(q.set("dilation", "wide"), ParameterError);
  EXPECT_THROW(q.set("dilatoin", "7"), ParameterError);
}

}  // namespace
}  // namespace edge_mcl
