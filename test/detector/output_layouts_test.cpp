// Every test writes the output of a network by hand, in one layout, so the true boxes are known.
#include <gtest/gtest.h>

#include <cmath>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/detector/output_layouts.h"

namespace edge_mcl {
namespace {

DetectorModel modelOf(OutputLayout layout, int classes, int width = 64, int height = 32) {
  DetectorModel m;
  m.name = "test";
  m.layout = layout;
  m.width = width;
  m.height = height;
  for (int c = 0; c < classes; ++c) m.classes.push_back("class" + std::to_string(c));
  return m;
}

cv::Mat tensor(const std::vector<int>& shape, float value = 0) {
  return {static_cast<int>(shape.size()), shape.data(), CV_32F, cv::Scalar(value)};
}

void expectBox(const NetworkBox& b, int class_id, float score, const cv::Rect2f& box) {
  EXPECT_EQ(b.class_id, class_id);
  EXPECT_NEAR(b.score, score, 1e-5);
  EXPECT_NEAR(b.box.x, box.x, 1e-3);
  EXPECT_NEAR(b.box.y, box.y, 1e-3);
  EXPECT_NEAR(b.box.width, box.width, 1e-3);
  EXPECT_NEAR(b.box.height, box.height, 1e-3);
}

TEST(OutputLayouts, Ssd) {
  cv::Mat out = tensor({1, 1, 3, 7});
  const float rows[3][7] = {{0, 1, 0.9f, 0.25f, 0.5f, 0.75f, 1},
                            {0, 0, 0.1f, 0, 0, 1, 1},
                            {0, 9, 0.1f, 0, 0, 1, 1}};  // there is no class 9
  std::copy(&rows[0][0], &rows[0][0] + 21, out.ptr<float>());
  const auto boxes = decodeBoxes(modelOf(OutputLayout::kSsd, 2), {out}, 0.5f);
  ASSERT_EQ(boxes.size(), 1u);
  expectBox(boxes[0], 1, 0.9f, {16, 16, 32, 16});
  out.ptr<float>()[2 * 7 + 2] = 0.9f;
  try {
    decodeBoxes(modelOf(OutputLayout::kSsd, 2), {out}, 0.5f);
    ADD_FAILURE() << "accepted";
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find("class 9, but 2 classes are named"), std::string::npos)
        << e.what();
  }
}

TEST(OutputLayouts, MaskRcnnTakesTheMaskOfItsClass) {
  cv::Mat out = tensor({1, 1, 1, 7}), masks = tensor({1, 2, 3, 3});
  const float row[7] = {0, 1, 0.9f, 0, 0, 0.5f, 0.5f};
  std::copy(row, row + 7, out.ptr<float>());
  masks.ptr<float>(0, 1)[4] = 0.75f;
  const auto boxes = decodeBoxes(modelOf(OutputLayout::kMaskRcnn, 2), {out, masks}, 0.5f);
  ASSERT_EQ(boxes.size(), 1u);
  ASSERT_EQ(boxes[0].mask.size(), cv::Size(3, 3));
  EXPECT_EQ(boxes[0].mask.at<float>(1, 1), 0.75f);
  EXPECT_EQ(boxes[0].mask.at<float>(0, 0), 0);
  EXPECT_THROW(decodeBoxes(modelOf(OutputLayout::kMaskRcnn, 2), {out}, 0.5f), InputError);
}

TEST(OutputLayouts, YoloRowsMultiplyObjectness) {
  cv::Mat out = tensor({1, 2, 8});
  const float rows[2][8] = {{30, 20, 10, 8, 0.8f, 0.1f, 0.9f, 0.2f},
                            {30, 20, 10, 8, 0.4f, 0.1f, 0.9f, 0.2f}};
  std::copy(&rows[0][0], &rows[0][0] + 16, out.ptr<float>());
  const auto boxes = decodeBoxes(modelOf(OutputLayout::kYolo, 3), {out}, 0.5f);
  ASSERT_EQ(boxes.size(), 1u);
  expectBox(boxes[0], 1, 0.72f, {25, 16, 10, 8});
}

TEST(OutputLayouts, DarknetSharesOfSeveralHeads) {
  cv::Mat a = tensor({1, 7}), b = tensor({1, 7});
  const float row[7] = {0.5f, 0.5f, 0.25f, 0.5f, 0.9f, 0.1f, 0.6f};
  std::copy(row, row + 7, a.ptr<float>());
  std::copy(row, row + 7, b.ptr<float>());
  const auto boxes = decodeBoxes(modelOf(OutputLayout::kDarknet, 2), {a, b}, 0.5f);
  ASSERT_EQ(boxes.size(), 2u);
  expectBox(boxes[1], 1, 0.6f, {24, 8, 16, 16});
}

TEST(OutputLayouts, YoloxCellsOfEveryStride) {
  // An input of 64 x 32 has 32 + 8 + 2 cells at the strides 8, 16 and 32. One object is in the
  // second cell of the last grid.
  cv::Mat out = tensor({1, 42, 7});
  float* row = out.ptr<float>() + 41 * 7;
  const float values[7] = {0.5f, 0.25f, std::log(0.5f), std::log(0.25f), 1, 0.2f, 0.9f};
  std::copy(values, values + 7, row);
  const auto boxes = decodeBoxes(modelOf(OutputLayout::kYolox, 2), {out}, 0.5f);
  ASSERT_EQ(boxes.size(), 1u);
  // The centre is ((1 + 0.5) * 32, 0.25 * 32) = (48, 8), the size is (16, 8).
  expectBox(boxes[0], 1, 0.9f, {40, 4, 16, 8});
  EXPECT_THROW(decodeBoxes(modelOf(OutputLayout::kYolox, 2), {tensor({1, 41, 7})}, 0.5f),
               InputError);
}

TEST(OutputLayouts, YoloV8IsTransposed) {
  cv::Mat out = tensor({1, 6, 3});
  const float values[6] = {30, 20, 10, 8, 0.1f, 0.9f};
  for (int k = 0; k < 6; ++k) out.ptr<float>()[k * 3 + 2] = values[k];
  const auto boxes = decodeBoxes(modelOf(OutputLayout::kYoloV8, 2), {out}, 0.5f);
  ASSERT_EQ(boxes.size(), 1u);
  expectBox(boxes[0], 1, 0.9f, {25, 16, 10, 8});
}

TEST(OutputLayouts, EndToEnd) {
  cv::Mat out = tensor({1, 300, 6});
  const float row[6] = {25, 16, 35, 24, 0.9f, 1};
  std::copy(row, row + 6, out.ptr<float>());
  const auto boxes = decodeBoxes(modelOf(OutputLayout::kEndToEnd, 2), {out}, 0.5f);
  ASSERT_EQ(boxes.size(), 1u);
  expectBox(boxes[0], 1, 0.9f, {25, 16, 10, 8});
  out.ptr<float>()[5] = 7;
  EXPECT_THROW(decodeBoxes(modelOf(OutputLayout::kEndToEnd, 2), {out}, 0.5f), InputError);
}

TEST(OutputLayouts, BoxesInSharesOfTheInput) {
  cv::Mat v8 = tensor({1, 6, 3}), yolo = tensor({1, 3, 7}), whole = tensor({1, 3, 6});
  const float centred[6] = {30 / 64.0f, 20 / 32.0f, 10 / 64.0f, 8 / 32.0f, 0.1f, 0.9f};
  for (int k = 0; k < 6; ++k) v8.ptr<float>()[k * 3 + 1] = centred[k];
  const float with_object[7] = {30 / 64.0f, 20 / 32.0f, 10 / 64.0f, 8 / 32.0f, 0.9f, 0, 1};
  std::copy(with_object, with_object + 7, yolo.ptr<float>());
  const float corners[6] = {25 / 64.0f, 16 / 32.0f, 35 / 64.0f, 24 / 32.0f, 0.9f, 1};
  std::copy(corners, corners + 6, whole.ptr<float>());
  for (const auto& [layout, out] :
       {std::pair{OutputLayout::kYoloV8, v8}, std::pair{OutputLayout::kYolo, yolo},
        std::pair{OutputLayout::kEndToEnd, whole}}) {
    const auto boxes = decodeBoxes(modelOf(layout, 2), {out}, 0.5f);
    ASSERT_EQ(boxes.size(), 1u);
    expectBox(boxes[0], 1, 0.9f, {25, 16, 10, 8});
  }
}

/// Two prototypes: the left half of the image, and everything. The weights take the second minus
/// twice the first, so the object is what lies to the right of the middle (32 px).
TEST(OutputLayouts, YoloV8SegMakesMasksOfPrototypes) {
  cv::Mat out = tensor({1, 8, 3}), prototypes = tensor({1, 2, 8, 16});
  const float values[8] = {32, 16, 16, 16, 0.1f, 0.9f, -20, 10};
  for (int k = 0; k < 8; ++k) out.ptr<float>()[k * 3 + 2] = values[k];
  for (int y = 0; y < 8; ++y)
    for (int x = 0; x < 16; ++x) {
      prototypes.ptr<float>(0, 0)[16 * y + x] = x < 8 ? 1 : 0;
      prototypes.ptr<float>(0, 1)[16 * y + x] = 1;
    }
  for (const bool swapped : {false, true}) {
    const std::vector<cv::Mat> outputs =
        swapped ? std::vector{prototypes, out} : std::vector{out, prototypes};
    const auto boxes = decodeBoxes(modelOf(OutputLayout::kYoloV8Seg, 2), outputs, 0.5f);
    ASSERT_EQ(boxes.size(), 1u);
    expectBox(boxes[0], 1, 0.9f, {24, 8, 16, 16});
    // The box is 4 x 4 cells of the prototypes.
    ASSERT_EQ(boxes[0].mask.size(), cv::Size(4, 4));
    for (int x = 0; x < 4; ++x) EXPECT_NEAR(boxes[0].mask.at<float>(1, x), x < 2 ? 0 : 1, 1e-4);
  }
}

TEST(OutputLayouts, AWrongLayoutNamesTheRightOne) {
  const auto textOf = [](OutputLayout layout, const std::vector<int>& shape) -> std::string {
    try {
      decodeBoxes(modelOf(layout, 2), {tensor(shape)}, 0.5f);
    } catch (const InputError& e) {
      return e.what();
    }
    return "";
  };
  const auto names = [](const std::string& text, const char* layout) {
    return text.find(std::string("layout: ") + layout) != std::string::npos;
  };
  EXPECT_TRUE(names(textOf(OutputLayout::kYoloV8, {1, 300, 6}), "end_to_end"));
  EXPECT_TRUE(names(textOf(OutputLayout::kYolo, {1, 6, 8400}), "yolov8"));
  EXPECT_TRUE(names(textOf(OutputLayout::kYoloV8, {1, 25200, 7}), "yolo or yolox"));
  EXPECT_TRUE(names(textOf(OutputLayout::kYoloV8, {1, 38, 8400}), "yolov8_seg"));
}

TEST(OutputLayouts, FastestDetCells) {
  cv::Mat out = tensor({1, 7, 2, 4});  // a grid of 4 x 2 cells
  const auto set = [&](int channel, float v) { out.ptr<float>(0, channel)[1 * 4 + 2] = v; };
  set(0, 0.81f);             // objectness
  set(1, std::atanh(0.5f));  // the centre is half a cell to the right
  set(2, std::atanh(-0.5f));
  set(3, 0);                   // half the width of the input
  set(4, std::log(1 / 3.0f));  // a quarter of the height of the input
  set(6, 0.49f);
  const auto boxes = decodeBoxes(modelOf(OutputLayout::kFastestDet, 2), {out}, 0.5f);
  ASSERT_EQ(boxes.size(), 1u);
  // The centre is (2.5 / 4 * 64, 0.5 / 2 * 32) = (40, 8), the size is (32, 8).
  expectBox(boxes[0], 1, std::pow(0.81f, 0.6f) * std::pow(0.49f, 0.4f), {24, 4, 32, 8});
}

TEST(OutputLayouts, AnotherShapeIsAnErrorThatNamesBoth) {
  for (const OutputLayout layout :
       {OutputLayout::kSsd, OutputLayout::kYolo, OutputLayout::kYolox, OutputLayout::kYoloV8,
        OutputLayout::kEndToEnd, OutputLayout::kDarknet, OutputLayout::kFastestDet}) {
    try {
      decodeBoxes(modelOf(layout, 2), {tensor({1, 5, 11})}, 0.5f);
      ADD_FAILURE() << "accepted";
    } catch (const InputError& e) {
      EXPECT_NE(std::string(e.what()).find("[1, 5, 11]"), std::string::npos) << e.what();
    }
  }
}

TEST(OutputLayouts, BoxesThatAreNoBoxesAreLeftOut) {
  cv::Mat out = tensor({1, 3, 6});
  const float rows[3][6] = {{30, 20, NAN, 8, 1, 1}, {30, 20, -5, 8, 1, 1}, {30, 20, 5, 8, 1, NAN}};
  std::copy(&rows[0][0], &rows[0][0] + 18, out.ptr<float>());
  EXPECT_TRUE(decodeBoxes(modelOf(OutputLayout::kYolo, 1), {out}, 0.5f).empty());
}

}  // namespace
}  // namespace edge_mcl
