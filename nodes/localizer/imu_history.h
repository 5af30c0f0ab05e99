/// Keeps the messages of an IMU and gives the orientation at the time of an image.
#pragma once

#include <sensor_msgs/Imu.h>

#include <Eigen/Core>
#include <deque>
#include <mutex>

namespace edge_mcl {

/// Orientation of an IMU at one time.
struct ImuOrientation {
  Eigen::Matrix3d R_world_imu;
  std_msgs::Header header;  ///< of a message beside it: its frame is that of the IMU
};

/// The functions may be called from any thread.
class ImuHistory {
 public:
  /// Adds the newest message. When its stamp is earlier than the one before, the clock was set
  /// back, and the history starts anew.
  void add(const sensor_msgs::ImuConstPtr& message);
  /// Interpolates between the messages before and after the stamp. When one of them is missing or
  /// farther than 50 ms away, the other one counts.
  /// @throws InputError when there is no message within 50 ms, or when the messages hold no valid
  /// orientation
  ImuOrientation at(const ros::Time& stamp) const;

 private:
  mutable std::mutex mutex_;
  std::deque<sensor_msgs::ImuConstPtr> messages_;  // newest last
};

}  // namespace edge_mcl
