/// Images in a bag, raw and compressed.
#pragma once

#include <rosbag/view.h>
#include <sensor_msgs/Image.h>

#include <map>
#include <memory>
#include <optional>
#include <string>

#include "edge_mcl/nodes/bags/bag_set.h"

namespace edge_mcl {

/// The image of a message, decoded when it is compressed. Without a stamp it gets the time at which
/// it was recorded. @return null when the message is not an image. @throws InputError when it
/// cannot be decoded
sensor_msgs::ImageConstPtr imageOf(const rosbag::MessageInstance& message);

/// Stamp of a message with an image, raw or compressed, without decoding it; none: it is no image.
std::optional<ros::Time> stampIn(const rosbag::MessageInstance& message);

/// Images of another topic (masks or depth) that belong to the images of the camera. They are
/// read ahead, because they may be recorded later than their image.
class CompanionImages {
 public:
  void open(const BagSet& bags, const std::string& topic);
  bool isOpen() const { return view_ != nullptr; }
  /// The image nearest to a stamp, within `tolerance` seconds; null: there is none. Images that are
  /// more than 0.1 s older are forgotten. @throws InputError when an image cannot be decoded
  sensor_msgs::ImageConstPtr take(const ros::Time& stamp, const ros::Time& received,
                                  double tolerance);

 private:
  std::unique_ptr<rosbag::View> view_;
  rosbag::View::iterator next_;
  std::map<ros::Time, sensor_msgs::ImageConstPtr> waiting_;
};

}  // namespace edge_mcl
