/// Gives the viewer the moments of a running ROS system.
#pragma once

#include <edge_mcl/DetectedObjects.h>
#include <edge_mcl/ForeignObjects.h>
#include <edge_mcl/Status.h>
#include <geometry_msgs/PoseArray.h>
#include <geometry_msgs/PoseStamped.h>
#include <geometry_msgs/PoseWithCovarianceStamped.h>
#include <image_transport/image_transport.h>
#include <ros/node_handle.h>
#include <sensor_msgs/CameraInfo.h>
#include <tf2_ros/transform_listener.h>

#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "edge_mcl/core/localization_map.h"
#include "edge_mcl/nodes/messages/image_subscriber.h"
#include "edge_mcl/viewer/drawing/view_parameters.h"
#include "edge_mcl/viewer/moments/view_source.h"

namespace edge_mcl {

/// Parameters of the viewer node. The functions of parameter_struct.h work with them.
struct ViewerNodeParameters : ViewParameters {
  std::string localizer = "edge_mcl_localizer";
  std::string model;
  std::string global_frame_id;
  std::string base_frame_id;
  std::string camera_file, image_transport, rectified;
  bool headless = false;
  std::string video;
  double video_rate = 10;
  std::string pictures;
  std::string pictures_at;
  int moments = 0;
  double wait = 0.3;

  template <class Visitor>
  void visit(Visitor&& v) {
    v("localizer", localizer, "", anyValue(), "node whose model and parameters are used");
    v("model", model, "", anyValue(),
      "model file; empty: the localizer's; without one only topics are shown");
    v("global_frame_id", global_frame_id, "", anyValue(),
      "frame of the model; empty: the localizer's");
    v("base_frame_id", base_frame_id, "", anyValue(), "frame of the robot; empty: the localizer's");
    v("camera_file", camera_file, "", anyValue(),
      "calibration file of the camera; empty: the localizer's, or the topic camera_info");
    v("image_transport", image_transport, "", anyValue(),
      "transport of the images: raw, compressed, or another plugin; empty: the localizer's");
    v("rectified", rectified, "", oneOf("|auto|true|false"),
      "the images are rectified; auto = the topic has rect in its name; empty: the localizer's");
    v("headless", headless, "", anyValue(), "no window: only video and pictures are written");
    v("video", video, "", anyValue(), "video file, .mp4 or .avi; empty: none");
    v("video_rate", video_rate, "Hz", above(0, 1000), "pictures per second of the video");
    v("pictures", pictures, "", anyValue(),
      "begin of the names of pictures, NAME-1.png and so on; empty: none");
    v("pictures_at", pictures_at, "s", anyValue(),
      "times of the pictures since the first moment, separated by commas; empty: the last moment");
    v("moments", moments, "", notNegative(),
      "without a window: number of moments after which the node ends; 0 = it ends with ROS");
    v("wait", wait, "s", from(0, 10), "time for which the parts of a moment are awaited");
    ViewParameters::visit(v);
  }
  /// Faults that the ranges do not cover, one text each.
  std::vector<std::string> faults() const;
  /// The times in `pictures_at`, s since the first moment. @throws ParameterError when they do not
  /// increase
  std::vector<double> pictureTimes() const;
};

/// Source of moments from ROS topics. It subscribes to `image`, `camera_info`, `mask`,
/// `detections`, `foreign_objects`, `depth`, `depth/camera_info`, `pose`, `particlecloud`,
/// `hypotheses`, `status` (of the localizer), `ground_truth` and tf. It publishes `initialpose`.
///
/// An image becomes a moment when the localizer has published a status for it. All messages of the
/// same stamp belong to the moment. When a message does not arrive within the parameter `wait`, the
/// moment is shown without it. `ViewMoment::problem` names the topics on which nothing arrives.
class LiveView : public ViewSource {
 public:
  LiveView(const ros::NodeHandle& nh, const ViewerNodeParameters& params);

  bool poll(ViewMoment* moment, HistoryView* history, double strip_seconds) override;
  void setPose(const PoseGaussian& pose) override;
  /// Gives the next moment in order, without a history, for recorders. @return false when there is
  /// none yet
  bool next(ViewMoment* moment);
  /// Text that names the topics on which nothing arrives; empty: messages arrive on all of them.
  std::string whatIsMissing();
  /// Whether the localizer has published a status.
  bool hasStatus();
  /// Sets the frames of the model and of the robot. To be called by the thread that takes the
  /// moments.
  void setFrames(const std::string& global, const std::string& base);

 private:
  /// The newest messages of one topic, by stamp.
  template <class Message>
  struct Kept {
    std::map<ros::Time, boost::shared_ptr<const Message>> by_stamp;
    ros::WallTime last;  // arrival of the newest message
    static constexpr size_t kMost = 64;
    void add(const boost::shared_ptr<const Message>& message) {
      by_stamp[message->header.stamp] = message;
      if (by_stamp.size() > kMost) by_stamp.erase(by_stamp.begin());
      last = ros::WallTime::now();
    }
    /// The message nearest to a stamp, within a tolerance (s); null: there is none.
    boost::shared_ptr<const Message> at(const ros::Time& stamp, double tolerance) const;
    bool has(const ros::Time& stamp) const { return by_stamp.count(stamp) > 0; }
    /// Whether a message of this stamp may have been forgotten.
    bool hasForgotten(const ros::Time& stamp) const {
      return by_stamp.size() == kMost && stamp < by_stamp.begin()->first;
    }
  };
  /// A status whose moment is not complete yet.
  struct Pending {
    StatusConstPtr status;
    ros::WallTime since;
  };

  template <class Message>
  void subscribe(const std::string& topic, Kept<Message>* kept);
  void receiveStatus(const StatusConstPtr& status);
  void restartIfTimeWentBack(const ros::Time& stamp);
  bool isComplete(const Status& status) const;
  ViewMoment assemble(const Status& status);
  void addCamera(const sensor_msgs::ImageConstPtr& image, ViewMoment* moment);
  void addDepth(const ros::Time& stamp, ViewMoment* moment);
  std::optional<Pose> mountingOf(const std_msgs::Header& sensor) const;
  std::string missing() const;
  bool takeLocked(ViewMoment* moment);
  bool nothingNew(ViewMoment* moment);

  ros::NodeHandle nh_;
  ViewerNodeParameters params_;
  tf2_ros::Buffer tf_;
  tf2_ros::TransformListener tf_listener_;
  image_transport::ImageTransport transport_;
  ros::Publisher initial_pose_;

  std::mutex mutex_;  // guards all members that callbacks write
  Kept<sensor_msgs::Image> images_, masks_, depths_;
  Kept<DetectedObjects> detections_;
  Kept<ForeignObjects> foreign_;
  Kept<geometry_msgs::PoseWithCovarianceStamped> poses_;
  Kept<geometry_msgs::PoseArray> clouds_, hypotheses_;
  Kept<geometry_msgs::PoseStamped> truths_;
  sensor_msgs::CameraInfoConstPtr info_, depth_info_;
  bool is_rectified_ = false;
  std::deque<Pending> pending_;
  ros::WallTime status_at_, started_ = ros::WallTime::now(), said_missing_at_;
  std::optional<ros::Time> first_, last_;
  ViewMoment last_moment_;
  ViewHistory history_;
  std::vector<ros::Subscriber> subscribers_;
  std::vector<ImageSubscriber> image_subscribers_;
};

}  // namespace edge_mcl
