// Prints the lines of a model, then the state of the localizer and the probability of its pose.
// usage: pose_watcher MODEL.obj     beside a running localizer
#include <edge_mcl/Status.h>
#include <ros/ros.h>

#include <cstdio>

#include "edge_mcl/core/localization_map.h"

void print(const edge_mcl::Status::ConstPtr& message) {
  std::printf("%s, probability %.2f\n", message->state_name.c_str(),
              static_cast<double>(message->probability));
}

int main(int argc, char** argv) {
  ros::init(argc, argv, "pose_watcher");
  if (argc != 2) {
    std::fprintf(stderr, "usage: pose_watcher MODEL.obj\n");
    return 2;
  }
  const edge_mcl::LocalizationMap map(argv[1], edge_mcl::Parameters());
  std::printf("%zu lines\n", map.edges().lines.size());
  if (!ros::master::check()) return 0;
  ros::NodeHandle node;
  const ros::Subscriber status = node.subscribe("edge_mcl_localizer/status", 10, print);
  ros::spin();
}
