#include "edge_mcl/nodes/bags/bag_images.h"

#include <sensor_msgs/CompressedImage.h>

#include <cmath>

#include "edge_mcl/nodes/messages/image_messages.h"

namespace edge_mcl {

sensor_msgs::ImageConstPtr imageOf(const rosbag::MessageInstance& message) {
  sensor_msgs::ImageConstPtr image = message.instantiate<sensor_msgs::Image>();
  if (!image) {
    const auto compressed = message.instantiate<sensor_msgs::CompressedImage>();
    if (!compressed) return nullptr;
    image = decode(*compressed, message.getTopic());
  }
  if (!image->header.stamp.isZero()) return image;
  const auto stamped = boost::make_shared<sensor_msgs::Image>(*image);
  stamped->header.stamp = message.getTime();
  return stamped;
}

std::optional<ros::Time> stampIn(const rosbag::MessageInstance& message) {
  if (const auto raw = message.instantiate<sensor_msgs::Image>()) return raw->header.stamp;
  if (const auto compressed = message.instantiate<sensor_msgs::CompressedImage>())
    return compressed->header.stamp;
  return std::nullopt;
}

void CompanionImages::open(const BagSet& bags, const std::string& topic) {
  view_ = bags.view({topic});
  next_ = view_->begin();
}

sensor_msgs::ImageConstPtr CompanionImages::take(const ros::Time& stamp, const ros::Time& received,
                                                 double tolerance) {
  if (!view_) return nullptr;
  constexpr double kLatest = 2;  // s that it may be recorded after its image
  while ((waiting_.empty() || waiting_.rbegin()->first < stamp) && next_ != view_->end() &&
         (*next_).getTime() <= received + ros::Duration(kLatest)) {
    const rosbag::MessageInstance message = *next_;
    ++next_;
    if (const auto image = imageOf(message)) waiting_[image->header.stamp] = image;
  }
  sensor_msgs::ImageConstPtr nearest;
  for (const auto& [at, message] : waiting_) {
    const double offset = std::abs((at - stamp).toSec());
    if (offset > tolerance) continue;
    tolerance = offset;
    nearest = message;
  }
  const ros::Duration kept(0.1);
  if (stamp.toSec() > kept.toSec())
    waiting_.erase(waiting_.begin(), waiting_.lower_bound(stamp - kept));
  return nearest;
}

}  // namespace edge_mcl
