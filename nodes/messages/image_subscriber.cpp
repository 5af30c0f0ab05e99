#include "edge_mcl/nodes/messages/image_subscriber.h"

#include <image_transport/exception.h>
#include <ros/console.h>

#include <utility>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/nodes/messages/image_messages.h"

namespace edge_mcl {

void ImageSubscriber::subscribe(const ros::NodeHandle& nh,
                                image_transport::ImageTransport* transport_plugins,
                                const std::string& topic, uint32_t queue_size,
                                const std::string& transport, Callback callback) {
  ros::NodeHandle handle(nh);
  const std::string resolved = handle.resolveName(topic);
  topic_ = uncompressedTopic(resolved);
  const bool is_ours = transport == "compressed" || transport == "compressedDepth";
  if (!isCompressedTopic(resolved) && !is_ours) {
    try {
      raw_ = transport_plugins->subscribe(topic, queue_size, callback, ros::VoidPtr(),
                                          image_transport::TransportHints(transport));
    } catch (const image_transport::Exception& e) {
      throw ParameterError("image_transport or depth_transport '" + transport +
                           "' is neither raw, compressed, compressedDepth nor a plugin that is "
                           "installed: " +
                           e.what());
    }
    return;
  }
  const std::string compressed =
      isCompressedTopic(resolved) ? resolved : resolved + "/" + transport;
  compressed_ = handle.subscribe<sensor_msgs::CompressedImage>(
      compressed, queue_size,
      boost::function<void(const sensor_msgs::CompressedImageConstPtr&)>(
          [callback = std::move(callback),
           compressed](const sensor_msgs::CompressedImageConstPtr& message) {
            try {
              callback(decode(*message, compressed));
            } catch (const Error& e) {
              ROS_WARN_THROTTLE(5, "%s", e.what());
            }
          }));
}

void ImageSubscriber::shutdown() {
  raw_.shutdown();
  compressed_.shutdown();
}

}  // namespace edge_mcl
