// Tests that images of all encodings are read. The truth is the picture from which each message is
// made by the definition of its encoding.
#include "edge_mcl/nodes/messages/image_messages.h"

#include <gtest/gtest.h>

#include <boost/make_shared.hpp>
#include <cmath>
#include <cstring>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "edge_mcl/core/base/error.h"

namespace edge_mcl {
namespace {

/// A smooth picture, so that half the colours of YUV and Bayer images can be interpolated.
cv::Mat picture() {
  cv::Mat image(24, 32, CV_8UC3);
  for (int y = 0; y < image.rows; ++y)
    for (int x = 0; x < image.cols; ++x)
      image.at<cv::Vec3b>(y, x) =
          cv::Vec3b(static_cast<uchar>(60 + 3 * x), static_cast<uchar>(80 + 4 * y),
                    static_cast<uchar>(90 + 2 * x + y));
  return image;
}

cv::Mat grey(const cv::Mat& color) {
  cv::Mat result;
  cv::cvtColor(color, result, cv::COLOR_BGR2GRAY);
  return result;
}

sensor_msgs::ImageConstPtr message(const cv::Mat& data, const std::string& encoding) {
  const auto image = boost::make_shared<sensor_msgs::Image>();
  image->encoding = encoding;
  image->width = static_cast<uint32_t>(data.cols);
  image->height = static_cast<uint32_t>(data.rows);
  image->step = static_cast<uint32_t>(data.cols * data.elemSize());
  image->data.assign(data.data, data.data + data.total() * data.elemSize());
  return image;
}

/// Largest difference inside the border, where Bayer patterns are extrapolated.
double difference(const cv::Mat& a, const cv::Mat& b) {
  const cv::Rect inside(2, 2, a.cols - 4, a.rows - 4);
  return cv::norm(a(inside), b(inside), cv::NORM_INF);
}

cv::Mat converted(const cv::Mat& image, int code) {
  cv::Mat result;
  cv::cvtColor(image, result, code);
  return result;
}

TEST(ImageMessages, ColoursWithoutLoss) {
  const cv::Mat color = picture();
  const std::pair<const char*, cv::Mat> cases[] = {{"bgr8", color},
                                                   {"8UC3", color},
                                                   {"rgb8", converted(color, cv::COLOR_BGR2RGB)},
                                                   {"bgra8", converted(color, cv::COLOR_BGR2BGRA)},
                                                   {"8UC4", converted(color, cv::COLOR_BGR2BGRA)},
                                                   {"rgba8", converted(color, cv::COLOR_BGR2RGBA)}};
  for (const auto& [encoding, data] : cases)
    EXPECT_EQ(cv::norm(fromMessage(message(data, encoding), "x"), color, cv::NORM_INF), 0)
        << encoding;
}

TEST(ImageMessages, GreyWithoutLoss) {
  const cv::Mat one = grey(picture());
  for (const char* encoding : {"mono8", "8UC1"})
    EXPECT_EQ(cv::norm(fromMessage(message(one, encoding), "x"), one, cv::NORM_INF), 0);
  cv::Mat wide;
  one.convertTo(wide, CV_16U, 16);
  for (const char* encoding : {"mono16", "16UC1"})
    EXPECT_EQ(cv::norm(fromMessage(message(wide, encoding), "x"), wide, cv::NORM_INF), 0);
}

/// In yuv422 the order of the bytes is U Y V Y, in yuv422_yuy2 it is Y U Y V.
TEST(ImageMessages, Yuv) {
  const cv::Mat color = picture(), yuv = converted(color, cv::COLOR_BGR2YUV);
  for (const bool first : {true, false}) {
    cv::Mat data(color.size(), CV_8UC2);
    for (int y = 0; y < data.rows; ++y)
      for (int x = 0; x < data.cols; ++x) {
        const cv::Vec3b& here = yuv.at<cv::Vec3b>(y, x - x % 2);
        const uchar luma = yuv.at<cv::Vec3b>(y, x)[0], chroma = x % 2 == 0 ? here[1] : here[2];
        data.at<cv::Vec2b>(y, x) = first ? cv::Vec2b(luma, chroma) : cv::Vec2b(chroma, luma);
      }
    const cv::Mat read = fromMessage(message(data, first ? "yuv422_yuy2" : "yuv422"), "x");
    // Video has another range of brightness (ITU-R BT.601) than the picture: 16 to 235.
    cv::Mat expected;
    cv::Mat(grey(color) - 16).convertTo(expected, CV_8U, 255.0 / 219);
    EXPECT_LE(difference(grey(read), expected), 6);
  }
}

TEST(ImageMessages, BayerPatternsOfEightAndSixteenBits) {
  const cv::Mat color = picture();
  // Colours of the pixels (0, 0), (0, 1), (1, 0), (1, 1): 0 blue, 1 green, 2 red.
  const std::pair<std::string, std::array<int, 4>> patterns[] = {{"bayer_rggb", {2, 1, 1, 0}},
                                                                 {"bayer_bggr", {0, 1, 1, 2}},
                                                                 {"bayer_gbrg", {1, 0, 2, 1}},
                                                                 {"bayer_grbg", {1, 2, 0, 1}}};
  for (const auto& [name, colours] : patterns) {
    cv::Mat data(color.size(), CV_8UC1), wide;
    for (int y = 0; y < data.rows; ++y)
      for (int x = 0; x < data.cols; ++x)
        data.at<uchar>(y, x) =
            color.at<cv::Vec3b>(y, x)[colours[static_cast<size_t>(2 * (y % 2) + x % 2)]];
    data.convertTo(wide, CV_16U, 16);
    // The picture is linear, so the interpolation is exact up to rounding.
    EXPECT_LE(difference(grey(fromMessage(message(data, name + "8"), "x")), grey(color)), 3)
        << name;
    cv::Mat from_wide;
    fromMessage(message(wide, name + "16"), "x").convertTo(from_wide, CV_8U, 1.0 / 16);
    EXPECT_LE(difference(from_wide, grey(color)), 3) << name;
  }
}

TEST(ImageMessages, WhatCannotBeUsedSaysWhy) {
  const auto textOf = [](const sensor_msgs::ImageConstPtr& image) -> std::string {
    try {
      fromMessage(image, "x");
    } catch (const InputError& e) {
      return e.what();
    }
    return "";
  };
  EXPECT_NE(textOf(message(cv::Mat(4, 4, CV_32F, cv::Scalar(1)), "32FC1")).find("depth"),
            std::string::npos);
  EXPECT_NE(textOf(message(cv::Mat(4, 4, CV_8U, cv::Scalar(1)), "jpeg")).find("/compressed"),
            std::string::npos);
  EXPECT_NE(textOf(message(cv::Mat(4, 4, CV_8U, cv::Scalar(1)), "yuv422")).find("truncated"),
            std::string::npos);
}

sensor_msgs::CompressedImage compressed(const cv::Mat& image, const std::string& ending,
                                        const std::string& format) {
  sensor_msgs::CompressedImage result;
  result.format = format;
  cv::imencode(ending, image, result.data);
  return result;
}

TEST(CompressedImages, PicturesOfAllKinds) {
  const cv::Mat color = picture();
  const auto png = decode(compressed(color, ".png", "bgr8; png compressed bgr8"), "x");
  EXPECT_EQ(cv::norm(fromMessage(png, "x"), color, cv::NORM_INF), 0);
  const auto jpeg = decode(compressed(color, ".jpg", "jpeg"), "x");
  EXPECT_LE(cv::norm(fromMessage(jpeg, "x"), color, cv::NORM_INF), 12);
  const auto mono = decode(compressed(grey(color), ".png", "mono8; png compressed "), "x");
  EXPECT_EQ(cv::norm(fromMessage(mono, "x"), grey(color), cv::NORM_INF), 0);
}

/// compressed_depth_image_transport writes 1/depth in steps: code = a / depth + b.
TEST(CompressedImages, DepthInMillimetresAndInMetres) {
  cv::Mat millimetres(4, 5, CV_16UC1);
  for (int i = 0; i < 20; ++i)
    millimetres.at<uint16_t>(i / 5, i % 5) = static_cast<uint16_t>(300 * i);
  const auto coded = [](const cv::Mat& image, float a, float b, const std::string& format) {
    sensor_msgs::CompressedImage message = compressed(image, ".png", format);
    std::vector<uint8_t> header(12, 0);
    std::memcpy(header.data() + 4, &a, 4);
    std::memcpy(header.data() + 8, &b, 4);
    message.data.insert(message.data.begin(), header.begin(), header.end());
    return message;
  };
  const auto whole = decode(coded(millimetres, 0, 0, "16UC1; compressedDepth"), "x");
  EXPECT_EQ(cv::norm(depthFromMessage(whole, "x"), millimetres, cv::NORM_INF), 0);
  constexpr float kA = 20000, kB = -1000;
  cv::Mat codes(1, 3, CV_16UC1);
  codes.at<uint16_t>(0, 0) = 0;  // unknown
  codes.at<uint16_t>(0, 1) = static_cast<uint16_t>(kA / 2 + kB);
  codes.at<uint16_t>(0, 2) = static_cast<uint16_t>(kA / 5 + kB);
  const auto metres = decode(coded(codes, kA, kB, "32FC1; compressedDepth png"), "x");
  const cv::Mat depth = depthFromMessage(metres, "x");
  EXPECT_TRUE(std::isnan(depth.at<float>(0, 0)));
  EXPECT_NEAR(depth.at<float>(0, 1), 2, 1e-5);
  EXPECT_NEAR(depth.at<float>(0, 2), 5, 1e-5);
}

TEST(CompressedImages, WhatCannotBeDecodedSaysWhy) {
  sensor_msgs::CompressedImage message = compressed(picture(), ".png", "png");
  message.data.resize(20);
  EXPECT_THROW(decode(message, "x"), InputError);
  message.data.clear();
  EXPECT_THROW(decode(message, "x"), InputError);
  message.format = "32FC1; compressedDepth rvl";
  EXPECT_THROW(decode(message, "x"), InputError);
}

TEST(CompressedImages, TopicsAreKnownByTheirNames) {
  EXPECT_TRUE(isCompressedTopic("/camera/image_raw/compressed"));
  EXPECT_TRUE(isCompressedTopic("/camera/depth/image_raw/compressedDepth"));
  EXPECT_FALSE(isCompressedTopic("/camera/image_compressed"));
  EXPECT_EQ(uncompressedTopic("/camera/image_raw/compressed"), "/camera/image_raw");
}

}  // namespace
}  // namespace edge_mcl
