/// Collects images, depth images and masks of all cameras into moments.
#pragma once

#include <ros/node_handle.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Image.h>

#include <atomic>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "edge_mcl/core/base/parameters.h"
#include "edge_mcl/nodes/common/patience.h"
#include "edge_mcl/nodes/localizer/mask_matcher.h"
#include "edge_mcl/nodes/localizer/node_parameters.h"
#include "edge_mcl/nodes/messages/image_subscriber.h"

namespace edge_mcl {

/// Messages that belong to one time stamp.
struct Moment {
  struct CameraPart {
    std::string origin;                       ///< name of the camera for messages
    std::optional<MaskMatcher::Match> match;  ///< image (without images: depth image) and its mask
    sensor_msgs::CameraInfoConstPtr info, depth_info;
    bool is_rectified = false, is_depth_rectified = false;
    std::string frame;                 ///< optical frame; empty: that of the image
    sensor_msgs::ImageConstPtr depth;  ///< null: none
  };
  ros::Time stamp;  ///< of the first camera's image
  std::vector<CameraPart> cameras;
  uint32_t received = 0, dropped = 0;  ///< images of all cameras so far
};

/// Subscribes to the topics of all cameras. The image of the first camera starts a moment; the
/// other parts are awaited for as long as the parameters say. The callbacks may run in any thread.
class MomentQueue {
 public:
  /// @throws InputError when a calibration file cannot be used
  MomentQueue(const ros::NodeHandle& nh, const NodeParameters& params, Cues cues);
  ~MomentQueue() { stop(); }
  MomentQueue(const MomentQueue&) = delete;
  MomentQueue& operator=(const MomentQueue&) = delete;

  /// Waits up to 10 ms for a moment and, when there is one, for its parts.
  std::optional<Moment> next();
  /// Ends all waiting; `next` returns nothing from now on.
  void stop();
  size_t cameraCount() const { return cameras_.size(); }
  /// Topic of the first camera's images when no image has come on any topic; else empty.
  std::string silentTopic();

 private:
  struct Camera {
    Camera(bool use_masks, double mask_timeout) : matcher(use_masks, mask_timeout) {}
    std::string name, origin, frame;
    bool is_rectified = false, is_depth_rectified = false;  // by their topics
    ImageSubscriber image_subscriber, mask_subscriber, depth_subscriber;
    ros::Subscriber info_subscriber, depth_info_subscriber;
    sensor_msgs::CameraInfoConstPtr info, depth_info;
    MaskMatcher matcher;
    std::deque<sensor_msgs::ImageConstPtr> depths;  // newest last
    Patience patience, depth_patience;              // for images of other cameras' moments
  };

  void subscribe(ros::NodeHandle nh, size_t camera);
  void receiveImage(size_t camera, const sensor_msgs::ImageConstPtr& image);
  void receiveDepth(size_t camera, const sensor_msgs::ImageConstPtr& depth);
  /// @param until s by the wall clock; a mask has its own timeout
  std::optional<MaskMatcher::Match> awaitImage(Camera* camera, const ros::Time& stamp, double until,
                                               std::unique_lock<std::mutex>* lock);
  sensor_msgs::ImageConstPtr awaitDepth(Camera* camera, const ros::Time& stamp,
                                        std::unique_lock<std::mutex>* lock);

  const NodeParameters params_;
  const Cues cues_;
  image_transport::ImageTransport transport_;
  std::mutex mutex_;  // guards what callbacks write
  std::condition_variable changed_;
  std::vector<Camera> cameras_;
  uint32_t images_received_ = 0;
  std::atomic<bool> running_{true};
};

}  // namespace edge_mcl
