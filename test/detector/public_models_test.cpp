// Tests public networks with the descriptions in this project. The files of the networks and the
// photographs are not part of the project. Where they are missing, the test is SKIPPED.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <set>

#include "edge_mcl/detector/mask_detector.h"

namespace edge_mcl {
namespace {

namespace fs = std::filesystem;

struct PublicModel {
  const char *description, *file, *config;
};
void PrintTo(const PublicModel& m, std::ostream* out) { *out << m.description; }

class PublicModels : public ::testing::TestWithParam<PublicModel> {};

/// The truth is what a person sees in the photographs: people in the foreground (fd_2), and a sofa,
/// a chair and a television (000000004495).
TEST_P(PublicModels, SeesWhatIsThere) {
  const fs::path files = EDGE_MCL_PUBLIC_MODELS, photos = EDGE_MCL_PHOTOS;
  DetectorModel model =
      DetectorModel::fromYamlFile(std::string(EDGE_MCL_MODELS) + "/" + GetParam().description);
  model.file = (files / GetParam().file).string();
  if (*GetParam().config) model.config_file = (files / GetParam().config).string();
  if (!fs::exists(model.file) || !fs::exists(photos / "fd_2.jpg"))
    GTEST_SKIP() << model.file << " or the photographs are not there";
  MaskDetector detector(model, {});
  const auto seen = [&](const char* photo) {
    const cv::Mat image = cv::imread((photos / photo).string());
    std::multiset<std::string> names;
    for (const Detection& d : detector.detect(image)) {
      names.insert(model.classes[static_cast<size_t>(d.class_id)]);
      EXPECT_EQ(d.mask.size(), image.size());
      EXPECT_GT(cv::countNonZero(d.mask), 0);
      EXPECT_TRUE((cv::Rect2f({}, image.size()) & d.box) == d.box) << "within the image";
    }
    return names;
  };
  EXPECT_GE(seen("fd_2.jpg").count("person"), 3u);
  const auto room = seen("000000004495.jpg");
  EXPECT_EQ(room.count("sofa"), 1u);
  EXPECT_EQ(room.count("tvmonitor"), 1u);
  EXPECT_GE(room.count("chair"), 1u);
}

INSTANTIATE_TEST_SUITE_P(
    Every, PublicModels,
    ::testing::Values(PublicModel{"yolox_nano.yaml", "yolox_nano_416.onnx", ""},
                      PublicModel{"fastestdet.yaml", "fastestdet.onnx", ""},
                      PublicModel{"yolo_fastest_xl.yaml", "yolo-fastest-1.1-xl.weights",
                                  "yolo-fastest-1.1-xl.cfg"}));

}  // namespace
}  // namespace edge_mcl
