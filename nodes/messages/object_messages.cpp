#include "edge_mcl/nodes/messages/object_messages.h"

#include <algorithm>

#include "edge_mcl/core/base/error.h"

namespace edge_mcl {

namespace {

/// @param xyz point or vector of a message
template <class Xyz>
void copy(const Eigen::Vector3d& from, Xyz* xyz) {
  xyz->x = from.x();
  xyz->y = from.y();
  xyz->z = from.z();
}

template <class Xyz>
Eigen::Vector3d vectorOf(const Xyz& xyz) {
  return {xyz.x, xyz.y, xyz.z};
}

/// Times of ROS are not negative.
ros::Time timeOf(double seconds) { return ros::Time(std::max(0.0, seconds)); }

}  // namespace

ForeignObject toMessage(const ObjectState& object, const std::string& class_name) {
  ForeignObject message;
  message.number = static_cast<uint32_t>(object.number);
  copy(object.box.center(), &message.center);
  copy(object.box.sizes(), &message.size);
  copy(object.velocity, &message.velocity);
  message.position_sigma = static_cast<float>(object.position_sigma);
  message.moving = static_cast<uint8_t>(object.is_moving);
  message.in_view = static_cast<uint8_t>(object.is_in_view);
  message.first_seen = timeOf(object.first_seen);
  message.last_seen = timeOf(object.last_seen);
  if (!object.is_moving) message.still_since = timeOf(object.still_since);
  message.class_name = class_name;
  return message;
}

ObjectState fromMessage(const ForeignObject& message) {
  const Eigen::Vector3d center = vectorOf(message.center), size = vectorOf(message.size);
  if (!center.allFinite() || !size.allFinite() || size.minCoeff() < 0)
    throw InputError("foreign object " + std::to_string(message.number) + ": no valid box");
  ObjectState object;
  object.number = static_cast<int>(message.number);
  object.box = {center - size / 2, center + size / 2};
  object.velocity = vectorOf(message.velocity);
  object.position_sigma = static_cast<double>(message.position_sigma);
  object.is_moving = message.moving;
  object.is_in_view = message.in_view;
  object.first_seen = message.first_seen.toSec();
  object.last_seen = message.last_seen.toSec();
  object.still_since = message.still_since.toSec();
  return object;
}

}  // namespace edge_mcl
