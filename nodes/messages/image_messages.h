/// Converts image messages, raw and compressed, to matrices.
#pragma once

#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>

#include <opencv2/core.hpp>
#include <string>

namespace edge_mcl {

/// Makes a message with a copy of the pixels. @param encoding e.g. "bgr8", "mono8", "32FC1".
sensor_msgs::ImagePtr toImage(const cv::Mat& image, const std::string& encoding,
                              const ros::Time& stamp, const std::string& frame);
/// Converts a camera image to bgr8, mono8 or mono16.
/// When no conversion is needed, the result shares the pixels of the message.
/// @throws InputError when the image is truncated or its encoding cannot be converted
cv::Mat fromMessage(const sensor_msgs::ImageConstPtr& message, const std::string& origin);
/// Depth image of a message: 16UC1 or mono16 (millimetres), or 32FC1 (metres). It shares the pixels
/// of the message. @throws InputError when the image is truncated, has another encoding or is
/// big-endian
cv::Mat depthFromMessage(const sensor_msgs::ImageConstPtr& message, const std::string& origin);
/// Mask of a message: mono8, non-zero = ignored. It shares the pixels of the message.
/// @throws InputError when the mask is truncated or has another encoding
cv::Mat maskFromMessage(const sensor_msgs::ImageConstPtr& message, const std::string& origin);

/// Decodes a compressed image as compressed_image_transport and compressed_depth_image_transport
/// send it: JPEG, PNG and other formats that OpenCV reads, and the PNG of depth images.
/// @throws InputError when it cannot be decoded
sensor_msgs::ImagePtr decode(const sensor_msgs::CompressedImage& message,
                             const std::string& origin);
/// Whether a topic is one of compressed images by its name: it ends in /compressed or
/// /compressedDepth.
bool isCompressedTopic(const std::string& topic);
/// Topic of the uncompressed images of a compressed topic, and any other topic as it is.
std::string uncompressedTopic(const std::string& topic);

}  // namespace edge_mcl
