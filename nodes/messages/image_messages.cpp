#include "edge_mcl/nodes/messages/image_messages.h"

#include <cv_bridge/cv_bridge.h>
#include <sensor_msgs/image_encodings.h>

#include <algorithm>
#include <cstring>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "edge_mcl/core/base/error.h"

namespace edge_mcl {

namespace {

namespace encodings = sensor_msgs::image_encodings;

/// YUV formats with two bytes per pixel, and OpenCV's conversions of them. Not all of them are
/// known to every version of sensor_msgs.
const std::map<std::string, int> kYuv = {{"yuv422", cv::COLOR_YUV2BGR_UYVY},
                                         {"uyvy", cv::COLOR_YUV2BGR_UYVY},
                                         {"yuv422_yuy2", cv::COLOR_YUV2BGR_YUY2},
                                         {"yuyv", cv::COLOR_YUV2BGR_YUY2}};

/// Bytes of a pixel of an encoding. @throws InputError when it is unknown
size_t pixelBytes(const std::string& encoding, const std::string& origin) {
  if (kYuv.count(encoding) > 0) return 2;
  try {
    return encodings::numChannels(encoding) * static_cast<size_t>(encodings::bitDepth(encoding)) /
           8;
  } catch (const std::exception&) {
    throw InputError(origin + ": unknown encoding '" + encoding +
                     "'; the driver must publish mono8, bgr8, rgb8, bayer_*8, yuv422, mono16 or "
                     "similar, or a compressed image on a topic that ends in /compressed");
  }
}

void checkSize(const sensor_msgs::Image& message, const std::string& origin) {
  const size_t pixel_bytes = pixelBytes(message.encoding, origin);
  if (message.width == 0 || message.height == 0 || message.step < pixel_bytes * message.width ||
      message.data.size() < static_cast<size_t>(message.step) * message.height)
    throw InputError(origin + ": truncated image: " + std::to_string(message.data.size()) +
                     " bytes for " + std::to_string(message.width) + "x" +
                     std::to_string(message.height) + " " + message.encoding);
}

/// Bayer pattern of 16 bits. cv_bridge converts only those of 8 bits.
cv::Mat greyOfBayer16(const sensor_msgs::ImageConstPtr& message) {
  // OpenCV names a pattern by the second row, beginning at the second pixel.
  static const std::map<std::string, int> kCodes = {
      {encodings::BAYER_RGGB16, cv::COLOR_BayerBG2GRAY},
      {encodings::BAYER_BGGR16, cv::COLOR_BayerRG2GRAY},
      {encodings::BAYER_GBRG16, cv::COLOR_BayerGR2GRAY},
      {encodings::BAYER_GRBG16, cv::COLOR_BayerGB2GRAY}};
  cv::Mat grey;
  cv::cvtColor(cv_bridge::toCvShare(message)->image, grey, kCodes.at(message->encoding));
  return grey;
}

/// The pixels of a message, which it goes on to own.
cv::Mat pixelsOf(const sensor_msgs::Image& message, int type) {
  return {static_cast<int>(message.height), static_cast<int>(message.width), type,
          const_cast<uint8_t*>(message.data.data()), message.step};
}

}  // namespace

sensor_msgs::ImagePtr toImage(const cv::Mat& image, const std::string& encoding,
                              const ros::Time& stamp, const std::string& frame) {
  std_msgs::Header header;
  header.stamp = stamp;
  header.frame_id = frame;
  return cv_bridge::CvImage(header, encoding, image).toImageMsg();
}

cv::Mat fromMessage(const sensor_msgs::ImageConstPtr& message, const std::string& origin) {
  checkSize(*message, origin);
  const std::string& encoding = message->encoding;
  if (encoding == encodings::TYPE_32FC1)
    throw InputError(origin +
                     ": a camera image of encoding 32FC1 cannot be used; is this a topic "
                     "of depth images?");
  try {
    if (const auto yuv = kYuv.find(encoding); yuv != kYuv.end()) {
      cv::Mat color;
      cv::cvtColor(pixelsOf(*message, CV_8UC2), color, yuv->second);
      return color;
    }
    if (encodings::isBayer(encoding) && encodings::bitDepth(encoding) == 16)
      return greyOfBayer16(message);
    // The encodings without colours are what cv_bridge and many drivers write. They have the order
    // of OpenCV.
    if (encoding == encodings::MONO8 || encoding == encodings::BGR8 ||
        encoding == encodings::MONO16 || encoding == encodings::TYPE_8UC1 ||
        encoding == encodings::TYPE_8UC3 || encoding == encodings::TYPE_16UC1)
      return cv_bridge::toCvShare(message)->image;
    if (encoding == encodings::TYPE_8UC4) {
      cv::Mat color;
      cv::cvtColor(cv_bridge::toCvShare(message)->image, color, cv::COLOR_BGRA2BGR);
      return color;
    }
    const bool grey = encodings::isMono(encoding);
    return cv_bridge::toCvShare(message, grey ? encodings::MONO8 : encodings::BGR8)->image;
  } catch (const std::exception& e) {
    throw InputError(origin + ": encoding '" + encoding +
                     "' cannot be used: " + std::string(e.what()));
  }
}

cv::Mat depthFromMessage(const sensor_msgs::ImageConstPtr& message, const std::string& origin) {
  checkSize(*message, origin);
  const bool metres = message->encoding == encodings::TYPE_32FC1;
  if (!metres && message->encoding != encodings::TYPE_16UC1 &&
      message->encoding != encodings::MONO16)
    throw InputError(origin + ": a depth image must be 16UC1 or 32FC1, not '" + message->encoding +
                     "'");
  if (message->is_bigendian) throw InputError(origin + ": a big-endian depth image cannot be used");
  return pixelsOf(*message, metres ? CV_32FC1 : CV_16UC1);
}

cv::Mat maskFromMessage(const sensor_msgs::ImageConstPtr& message, const std::string& origin) {
  checkSize(*message, origin);
  if (kYuv.count(message->encoding) > 0 || encodings::numChannels(message->encoding) != 1 ||
      encodings::bitDepth(message->encoding) != 8)
    throw InputError(origin + ": a mask must be mono8, not '" + message->encoding + "'");
  return pixelsOf(*message, CV_8UC1);
}

namespace {

bool endsWith(const std::string& text, const std::string& end) {
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

cv::Mat decodePicture(const uint8_t* data, size_t size, const std::string& origin) {
  cv::Mat picture;
  try {
    if (size > 0) {
      const cv::Mat bytes(1, static_cast<int>(size), CV_8UC1, const_cast<uint8_t*>(data));
      picture = cv::imdecode(bytes, cv::IMREAD_UNCHANGED);
    }
  } catch (const cv::Exception&) {
    picture.release();
  }
  if (picture.empty()) throw InputError(origin + ": the compressed image cannot be decoded");
  return picture;
}

/// Depth images have a header before the PNG: a format, and two numbers that turn quantised inverse
/// depth into metres (compressed_depth_image_transport, compression_common.h).
struct DepthHeader {
  int32_t format;
  float quantum_a, quantum_b;
};

cv::Mat decodeDepth(const sensor_msgs::CompressedImage& message, bool metres,
                    const std::string& origin) {
  if (message.format.find("rvl") != std::string::npos)
    throw InputError(origin +
                     ": depth images compressed by RVL cannot be used; set the driver's "
                     "format to png");
  DepthHeader header{};
  if (message.data.size() <= sizeof header)
    throw InputError(origin + ": the compressed depth image is truncated");
  std::memcpy(&header, message.data.data(), sizeof header);
  cv::Mat coded = decodePicture(message.data.data() + sizeof header,
                                message.data.size() - sizeof header, origin);
  if (coded.type() != CV_16UC1)
    throw InputError(origin + ": a compressed depth image must have one channel of 16 bits");
  if (!metres) return coded;
  cv::Mat depth(coded.size(), CV_32FC1);
  for (int y = 0; y < coded.rows; ++y)
    for (int x = 0; x < coded.cols; ++x) {
      const uint16_t code = coded.at<uint16_t>(y, x);
      depth.at<float>(y, x) =
          code == 0 ? NAN : header.quantum_a / (static_cast<float>(code) - header.quantum_b);
    }
  return depth;
}

std::string encodingOf(const cv::Mat& picture, const std::string& origin) {
  switch (picture.type()) {
    case CV_8UC1:
      return encodings::MONO8;
    case CV_8UC3:
      return encodings::BGR8;
    case CV_8UC4:
      return encodings::BGRA8;
    case CV_16UC1:
      return encodings::MONO16;
    case CV_16UC3:
      return encodings::BGR16;
    default:
      throw InputError(origin + ": the compressed image has an unknown pixel type");
  }
}

}  // namespace

sensor_msgs::ImagePtr decode(const sensor_msgs::CompressedImage& message,
                             const std::string& origin) {
  cv::Mat picture;
  std::string encoding;
  if (message.format.find("compressedDepth") != std::string::npos) {
    const bool metres = message.format.rfind("32FC1", 0) == 0;
    picture = decodeDepth(message, metres, origin);
    encoding = metres ? encodings::TYPE_32FC1 : encodings::TYPE_16UC1;
  } else {
    picture = decodePicture(message.data.data(), message.data.size(), origin);
    encoding = encodingOf(picture, origin);
  }
  sensor_msgs::ImagePtr image = cv_bridge::CvImage(message.header, encoding, picture).toImageMsg();
  return image;
}

bool isCompressedTopic(const std::string& topic) { return uncompressedTopic(topic) != topic; }

std::string uncompressedTopic(const std::string& topic) {
  for (const char* end : {"/compressed", "/compressedDepth"})
    if (endsWith(topic, end)) return topic.substr(0, topic.size() - std::strlen(end));
  return topic;
}

}  // namespace edge_mcl
