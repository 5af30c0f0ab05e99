/// Publishes the objects that are not in the model.
#pragma once

#include <edge_mcl/DetectedObjects.h>
#include <edge_mcl/ForeignObjects.h>
#include <ros/node_handle.h>

#include <map>
#include <mutex>
#include <string>

#include "edge_mcl/localization/objects/object_names.h"
#include "edge_mcl/localization/tracking/live_localizer.h"

namespace edge_mcl {

/// Publishes foreign_objects and foreign_object_markers, and takes the names of the objects from
/// the topic detections of a detector node.
class ObjectPublisher {
 public:
  ObjectPublisher(ros::NodeHandle nh, ros::NodeHandle private_nh, std::string frame_id);

  /// @param stamp of the image
  void publish(const LiveInput& input, const LiveResult& result, const ros::Time& stamp);

 private:
  void receive(const DetectedObjectsConstPtr& detections);
  void publishMarkers(const ForeignObjects& list);

  std::string frame_id_;
  ros::Publisher objects_, markers_;
  std::mutex names_mutex_;  // detections arrive in another thread than results
  ObjectNames names_;
  std::map<int32_t, float> ages_;  // of the newest detections, by number of the detector's track
  ros::Subscriber detections_;     // the last one: its callback needs all others
};

}  // namespace edge_mcl
