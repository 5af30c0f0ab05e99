/// Names of foreign objects, from a network that sees some of them.
#pragma once

#include <deque>
#include <map>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "edge_mcl/localization/objects/object_follower.h"

namespace edge_mcl {

/// Gives foreign objects the names that a network has for what it sees at the same places. The
/// network may be late by two seconds.
class ObjectNames {
 public:
  /// What the network found in an image.
  struct Found {
    std::string name;
    double score = 0;  ///< 0 to 1
    cv::Rect2d box;    ///< pixels
  };
  /// Where an image has the objects. @param time of the image, s
  void remember(double time, const CameraModel& camera, const Pose& T_map_camera,
                const std::vector<ObjectState>& objects);
  /// Takes what the network found in the image of this time. It is left out when no image of this
  /// time is remembered.
  void hear(double time, const std::vector<Found>& found);
  /// The name that the network gave an object most surely. Empty: none
  std::string nameOf(int number) const;

 private:
  struct Seen {
    double time;
    std::map<int, cv::Rect2d> boxes;  // by number of the object
  };
  std::deque<Seen> seen_;
  std::map<int, std::map<std::string, double>> scores_;  // sums, by number of the object and name
};

}  // namespace edge_mcl
