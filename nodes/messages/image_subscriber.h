/// Subscribes to images, raw or compressed.
#pragma once

#include <image_transport/image_transport.h>
#include <ros/node_handle.h>
#include <sensor_msgs/CompressedImage.h>
#include <sensor_msgs/Image.h>

#include <memory>
#include <string>

namespace edge_mcl {

/// A subscription that decodes compressed images itself, since Debian has no plugin of
/// image_transport for them.
class ImageSubscriber {
 public:
  using Callback = boost::function<void(const sensor_msgs::ImageConstPtr&)>;

  /// Subscribes.
  /// @param topic of the raw images, before remapping. When it is remapped to a topic that ends in
  ///   /compressed or /compressedDepth, the compressed images of that topic are used.
  /// @param transport raw, compressed, compressedDepth, or the name of another plugin.
  void subscribe(const ros::NodeHandle& nh, image_transport::ImageTransport* transport_plugins,
                 const std::string& topic, uint32_t queue_size, const std::string& transport,
                 Callback callback);
  void shutdown();
  /// Topic of the raw images, after remapping.
  const std::string& topic() const { return topic_; }

 private:
  std::string topic_;
  image_transport::Subscriber raw_;
  ros::Subscriber compressed_;
};

}  // namespace edge_mcl
