/// A live ROS system as the viewer shows it.
#pragma once

#include <edge_mcl/DetectedObjects.h>
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
#include "edge_mcl/viewer/drawing/view_parameters.h"
#include "edge_mcl/viewer/moments/view_source.h"

namespace edge_mcl {

struct ViewerNodeParameters : ViewParameters {
  std::string localizer = "edge_mcl_localizer";  ///< node whose model and parameters are used
  std::string model;  ///< empty: the localizer's; none there: only what topics say is shown
  std::string global_frame_id;  ///< of the model; empty: the localizer's
  std::string base_frame_id;    ///< likewise
  bool headless = false;        ///< no window: a video or pictures
  std::string video;            ///< .mp4 or .avi; empty: none
  double video_rate = 10;       ///< pictures per second of the video
  std::string pictures;         ///< BEGIN-1.png, ...; empty: none
  std::string pictures_at;  ///< s since the first moment, comma separated; empty: the last moment
  int moments = 0;          ///< headless: ends after so many; 0: with ROS
  double wait = 0.3;        ///< s that a moment waits for what belongs to it

  template <class Visitor>
  void visit(Visitor&& v) {
    v("localizer", localizer);
    v("model", model);
    v("global_frame_id", global_frame_id);
    v("base_frame_id", base_frame_id);
    v("headless", headless);
    v("video", video);
    v("video_rate", video_rate);
    v("pictures", pictures);
    v("pictures_at", pictures_at);
    v("moments", moments);
    v("wait", wait);
    ViewParameters::visit(v);
  }
  std::vector<std::string> faults() const;
  /// Of `pictures_at`. @throws ParameterError
  std::vector<double> pictureTimes() const;
};

/// Subscribes to `image`, `camera_info`, `mask`, `detections`, `depth`, `depth/camera_info`,
/// `pose`, `particlecloud`, `hypotheses`, `status` (of the localizer), `ground_truth` and tf;
/// publishes `initialpose`. A moment is an image that the localizer has given a status for, with
/// all of the same stamp; what does not come is said, and done without.
class LiveView : public ViewSource {
 public:
  LiveView(const ros::NodeHandle& nh, const ViewerNodeParameters& params);

  bool poll(ViewMoment* moment, HistoryView* history, double strip_seconds) override;
  void setPose(const PoseGaussian& pose) override;
  /// The next moment in order, without a history; for recorders. @return false: none yet.
  bool next(ViewMoment* moment);
  /// Topics on which nothing comes, though it should; empty: none.
  std::string whatIsMissing();
  /// Whether the localizer has said anything yet.
  bool hasStatus();
  /// To be called by the thread that takes the moments.
  void setFrames(const std::string& global, const std::string& base);

 private:
  /// Messages of one topic by stamp; the oldest are forgotten.
  template <class Message>
  struct Kept {
    std::map<ros::Time, boost::shared_ptr<const Message>> by_stamp;
    ros::WallTime last;
    static constexpr size_t kMost = 64;
    void add(const boost::shared_ptr<const Message>& message) {
      by_stamp[message->header.stamp] = message;
      if (by_stamp.size() > kMost) by_stamp.erase(by_stamp.begin());
      last = ros::WallTime::now();
    }
    /// The nearest within a tolerance, s; null: none.
    boost::shared_ptr<const Message> at(const ros::Time& stamp, double tolerance) const;
    bool has(const ros::Time& stamp) const { return by_stamp.count(stamp) > 0; }
    /// Whether a message of this stamp may have been forgotten.
    bool hasForgotten(const ros::Time& stamp) const {
      return by_stamp.size() == kMost && stamp < by_stamp.begin()->first;
    }
  };
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

  std::mutex mutex_;  // guards what callbacks write
  Kept<sensor_msgs::Image> images_, masks_, depths_;
  Kept<DetectedObjects> detections_;
  Kept<geometry_msgs::PoseWithCovarianceStamped> poses_;
  Kept<geometry_msgs::PoseArray> clouds_, hypotheses_;
  Kept<geometry_msgs::PoseStamped> truths_;
  sensor_msgs::CameraInfoConstPtr info_, depth_info_;
  std::deque<Pending> pending_;
  ros::WallTime status_at_, started_ = ros::WallTime::now(), said_missing_at_;
  std::optional<ros::Time> first_, last_;
  ViewMoment last_moment_;
  ViewHistory history_;
  std::string problem_;  // of the last broken message
  std::vector<ros::Subscriber> subscribers_;
  std::vector<image_transport::Subscriber> image_subscribers_;
};

/// Runs until ROS ends, the window is closed, or `moments` are recorded. @throws ParameterError,
/// InputError, Error
void runViewer(const ros::NodeHandle& nh, const ros::NodeHandle& private_nh);

}  // namespace edge_mcl
