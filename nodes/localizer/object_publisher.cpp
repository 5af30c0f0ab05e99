#include "edge_mcl/nodes/localizer/object_publisher.h"

#include <visualization_msgs/MarkerArray.h>

#include <utility>

#include "edge_mcl/nodes/messages/object_messages.h"

namespace edge_mcl {

namespace {

using visualization_msgs::Marker;

Marker markerOf(const ForeignObject& object, const char* group, int type) {
  Marker marker;
  marker.ns = group;
  marker.id = static_cast<int>(object.number);
  marker.type = type;
  marker.pose.orientation.w = 1;
  marker.pose.position = object.center;
  return marker;
}

Marker boxOf(const ForeignObject& object) {
  Marker box = markerOf(object, "boxes", Marker::CUBE);
  box.scale = object.size;
  box.color.r = object.moving ? 1.0F : 0.2F;
  box.color.g = 0.5F;
  box.color.b = object.moving ? 0.1F : 1.0F;
  box.color.a = object.in_view ? 0.5F : 0.2F;
  return box;
}

Marker textOf(const ForeignObject& object) {
  constexpr double kAbove = 0.15;  // m
  Marker text = markerOf(object, "numbers", Marker::TEXT_VIEW_FACING);
  text.pose.position.z += object.size.z / 2 + kAbove;
  text.scale.z = 0.2;
  text.color.r = text.color.g = text.color.b = text.color.a = 1;
  text.text = std::to_string(object.number);
  if (!object.class_name.empty()) text.text += " " + object.class_name;
  return text;
}

}  // namespace

ObjectPublisher::ObjectPublisher(ros::NodeHandle nh, ros::NodeHandle private_nh,
                                 std::string frame_id)
    : frame_id_(std::move(frame_id)),
      objects_(nh.advertise<ForeignObjects>("foreign_objects", 5)),
      markers_(private_nh.advertise<visualization_msgs::MarkerArray>("foreign_object_markers", 2)),
      detections_(nh.subscribe("detections", 5, &ObjectPublisher::receive, this)) {}

void ObjectPublisher::receive(const DetectedObjectsConstPtr& detections) {
  const std::lock_guard<std::mutex> lock(names_mutex_);
  std::vector<ObjectNames::Found> found;
  std::map<int32_t, float> ages;
  for (const DetectedObject& d : detections->objects) {
    ages[d.track_id] = d.age;
    // Between two runs of the network the detector repeats what it found. That proves nothing.
    const auto before = ages_.find(d.track_id);
    if (before != ages_.end() && d.age > before->second) continue;
    found.push_back({d.class_name, static_cast<double>(d.score),
                     cv::Rect2d(static_cast<double>(d.x), static_cast<double>(d.y),
                                static_cast<double>(d.width), static_cast<double>(d.height))});
  }
  ages_ = std::move(ages);
  names_.hear(detections->header.stamp.toSec(), found);
}

void ObjectPublisher::publish(const LiveInput& input, const LiveResult& result,
                              const ros::Time& stamp) {
  ForeignObjects list;
  list.header.frame_id = frame_id_;
  list.header.stamp = stamp;
  {
    const std::lock_guard<std::mutex> lock(names_mutex_);
    if (result.updated && !input.images.empty()) {
      const LiveInput::CameraImage& view = input.images.front();
      names_.remember(stamp.toSec(), view.camera, result.estimate.mean * view.T_base_camera,
                      result.objects);
    }
    for (const ObjectState& object : result.objects)
      list.objects.push_back(toMessage(object, names_.nameOf(object.number)));
  }
  objects_.publish(list);
  if (markers_.getNumSubscribers() > 0) publishMarkers(list);
}

void ObjectPublisher::publishMarkers(const ForeignObjects& list) {
  visualization_msgs::MarkerArray markers;
  // A viewer that comes later needs no history: all markers are sent each time.
  Marker all;
  all.action = Marker::DELETEALL;
  markers.markers.push_back(all);
  for (const ForeignObject& object : list.objects) {
    markers.markers.push_back(boxOf(object));
    markers.markers.push_back(textOf(object));
  }
  for (Marker& marker : markers.markers) marker.header = list.header;
  markers_.publish(markers);
}

}  // namespace edge_mcl
