/// Tests how the viewer uses the messages of a live system, message by message.
#include <gtest/gtest.h>
#include <ros/callback_queue.h>
#include <ros/ros.h>
#include <tf2_msgs/TFMessage.h>

#include <chrono>
#include <functional>
#include <thread>

#include "edge_mcl/nodes/viewer/viewer_node.h"

namespace edge_mcl {
namespace {

bool within(double seconds, const std::function<bool()>& condition) {
  using Clock = std::chrono::steady_clock;
  const auto end = Clock::now() + std::chrono::duration<double>(seconds);
  while (!condition() && Clock::now() < end)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  return condition();
}

/// Messages are published as shared objects. So they are in the queue when publish() returns.
class LiveViewTest : public ::testing::Test {
 protected:
  void SetUp() override {
    nh_.setCallbackQueue(&queue_);
    image_ = nh_.advertise<sensor_msgs::Image>("image", 4);
    info_ = nh_.advertise<sensor_msgs::CameraInfo>("camera_info", 4);
    pose_ = nh_.advertise<geometry_msgs::PoseWithCovarianceStamped>("pose", 4);
    status_ = nh_.advertise<Status>("status", 4);
    tf_ = nh_.advertise<tf2_msgs::TFMessage>("/tf", 4);
    ViewerNodeParameters params;
    params.base_frame_id = "base";
    params.global_frame_id = "map";
    view_ = std::make_unique<LiveView>(nh_, params);
    for (const ros::Publisher& publisher : {image_, info_, pose_, status_, tf_})
      ASSERT_TRUE(within(10, [&] { return publisher.getNumSubscribers() > 0; }));
  }

  template <class Message>
  void send(const ros::Publisher& publisher, const boost::shared_ptr<Message>& message,
            double stamp) {
    message->header.stamp = ros::Time(stamp);
    publisher.publish(message);
    queue_.callAvailable();
  }

  void sendMoment(double stamp) {
    const auto image = boost::make_shared<sensor_msgs::Image>();
    image->header.frame_id = "camera";
    image->encoding = "mono8";
    image->width = image->step = 64;
    image->height = 48;
    image->data.assign(64 * 48, 90);
    send(image_, image, stamp);
    const auto pose = boost::make_shared<geometry_msgs::PoseWithCovarianceStamped>();
    pose->pose.pose.orientation.w = 1;
    send(pose_, pose, stamp);
    const auto status = boost::make_shared<Status>();
    status->state = Status::TRACKING;
    send(status_, status, stamp);
  }

  void sendMounting(double stamp, double x) {
    const auto message = boost::make_shared<tf2_msgs::TFMessage>();
    message->transforms.resize(1);
    geometry_msgs::TransformStamped& transform = message->transforms.front();
    transform.header.stamp = ros::Time(stamp);
    transform.header.frame_id = "base";
    transform.child_frame_id = "camera";
    transform.transform.translation.x = x;
    transform.transform.rotation.w = 1;
    tf_.publish(message);
  }

  ros::NodeHandle nh_{"live_view"};
  ros::CallbackQueue queue_;
  ros::Publisher image_, info_, pose_, status_, tf_;
  std::unique_ptr<LiveView> view_;
};

/// More moments come than the viewer keeps images for. It must leave out moments instead of showing
/// them without an image.
TEST_F(LiveViewTest, WhoIsFarBehindLeavesMomentsOutRatherThanShowingThemEmpty) {
  constexpr int kMoments = 150;  // more than the images that the viewer keeps
  for (int i = 0; i < kMoments; ++i) sendMoment(10 + 0.03 * i);
  // Longer than the viewer waits for parts of a moment.
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  ViewMoment moment;
  int taken = 0;
  while (view_->next(&moment)) {
    ++taken;
    EXPECT_FALSE(moment.image.empty()) << moment.time;
    EXPECT_TRUE(moment.has_pose) << moment.time;
  }
  EXPECT_GE(taken, 60);
  EXPECT_NEAR(moment.time, 10 + 0.03 * (kMoments - 1), 1e-6);
}

/// The camera moves from x = 1 m at 10 s to x = 2 m at 12 s. The true mounting at 11 s is x = 1.5
/// m.
TEST_F(LiveViewTest, AMountThatMovesIsWhereItWasThen) {
  const auto info = boost::make_shared<sensor_msgs::CameraInfo>();
  info->width = 64;
  info->height = 48;
  info->distortion_model = "plumb_bob";
  info->D.assign(5, 0);
  info->K = {50, 0, 32, 0, 50, 24, 0, 0, 1};
  send(info_, info, 10);
  sendMounting(10, 1);
  sendMounting(12, 2);
  std::this_thread::sleep_for(std::chrono::seconds(1));  // tf listens in its own thread
  ViewMoment moment;
  sendMoment(11);
  ASSERT_TRUE(view_->next(&moment));
  ASSERT_TRUE(moment.has_camera) << moment.problem;
  EXPECT_NEAR(moment.T_base_camera.translation().x(), 1.5, 1e-6);
  sendMoment(13);
  ASSERT_TRUE(view_->next(&moment));
  EXPECT_NEAR(moment.T_base_camera.translation().x(), 2, 1e-6)
      << "the newest, where it is not known";
}

}  // namespace
}  // namespace edge_mcl

int main(int argc, char** argv) {
  ::testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "live_view_test");
  const ros::NodeHandle keep_alive;
  return RUN_ALL_TESTS();
}
