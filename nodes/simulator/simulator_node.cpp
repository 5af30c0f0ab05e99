#include "edge_mcl/nodes/simulator/simulator_node.h"

#include <ros/console.h>
#include <rosgraph_msgs/Clock.h>

#include <cmath>
#include <limits>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/nodes/common/private_parameters.h"
#include "edge_mcl/nodes/messages/ros_conversions.h"

namespace edge_mcl {

namespace {

struct SimulatorParameters {
  std::string scenario;
  bool live = false;
  double speed = 1;
  uint64_t seed = 0;

  template <class Visitor>
  void visit(Visitor&& v) {
    v("scenario", scenario, "", anyValue(), "YAML file of the flight");
    v("live", live, "", anyValue(), "cmd_vel flies the robot in place of the scenario's path");
    v("speed", speed, "", notNegative(), "factor on real time; 0 = as fast as possible");
    v("seed", seed, "", anyValue(), "seed of all noise; 0 = the seed of the scenario");
  }
  std::vector<std::string> faults() const {
    if (scenario.empty()) return {"~scenario is not set"};
    return {};
  }
};

}  // namespace

SimulatorNode::SimulatorNode(const ros::NodeHandle& nh, const ros::NodeHandle& private_nh)
    : nh_(nh) {
  const auto params = readParameterStruct<SimulatorParameters>(private_nh);
  live_ = params.live;
  speed_ = params.speed;
  Scenario scenario = Scenario::fromYamlFile(params.scenario);
  if (params.seed > 0) scenario.seed = params.seed;
  simulator_ = std::make_unique<Simulator>(std::move(scenario));
  const Scenario& s = simulator_->scenario();
  messages_ = std::make_unique<RecordingMessages>(simulator_->setup());
  imu_ = std::make_unique<ImuSensor>(s.imu, s.seed * 3);
  begin_ = imu_time_ = s.path.begin();
  if (live_)
    flight_ = std::make_unique<LiveFlight>(
        s.cameraAt(begin_) * s.T_body_camera().inverse(), FlightResponse(),
        [this](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
          return simulator_->isFree(a, b);
        });
  nh_.param("/use_sim_time", simulated_clock_, false);
  namespace topics = recording_topics;
  if (simulated_clock_) clock_ = nh_.advertise<rosgraph_msgs::Clock>("/clock", 10);
  image_ = nh_.advertise<sensor_msgs::Image>(topics::kImage, 2);
  info_ = nh_.advertise<sensor_msgs::CameraInfo>(topics::kInfo, 2, true);
  depth_ = nh_.advertise<sensor_msgs::Image>(topics::kDepth, 2);
  depth_info_ = nh_.advertise<sensor_msgs::CameraInfo>(topics::kDepthInfo, 2, true);
  mask_ = nh_.advertise<sensor_msgs::Image>(topics::kMask, 2);
  imu_publisher_ = nh_.advertise<sensor_msgs::Imu>(topics::kImu, 50);
  odometry_ = nh_.advertise<nav_msgs::Odometry>(topics::kOdometry, 10);
  truth_ = nh_.advertise<geometry_msgs::PoseStamped>(topics::kTruth, 10);
  initial_pose_ =
      nh_.advertise<geometry_msgs::PoseWithCovarianceStamped>(topics::kInitialPose, 1, true);
  command_subscriber_ = nh_.subscribe<geometry_msgs::Twist>(
      "cmd_vel", 5,
      boost::function<void(const geometry_msgs::TwistConstPtr&)>(
          [this](const geometry_msgs::TwistConstPtr& twist) {
            const std::lock_guard<std::mutex> lock(command_mutex_);
            command_ = *twist;
          }));
}

double SimulatorNode::endTime() const {
  return live_ ? std::numeric_limits<double>::infinity() : simulator_->scenario().path.end();
}

ros::Time SimulatorNode::stampOf(double time) const {
  return epoch_ + ros::Duration(time - begin_);
}

Pose SimulatorNode::cameraAt(double time) const {
  const Scenario& s = simulator_->scenario();
  return live_ ? flight_->poseNear(time) * s.T_body_camera() : s.cameraAt(time);
}

Eigen::Matrix3d SimulatorNode::attitudeAt(double time) const {
  return (cameraAt(time) * simulator_->scenario().T_body_camera().inverse()).linear();
}

void SimulatorNode::pace(double time) {
  if (speed_ > 0) {
    const ros::WallTime due = started_ + ros::WallDuration((time - begin_) / speed_);
    const ros::WallDuration left = due - ros::WallTime::now();
    if (left.toSec() > 0)
      left.sleep();
    else if (simulated_clock_)
      started_ -= left;  // the images took too long, so the schedule is shifted by this time
  }
  if (simulated_clock_) {
    rosgraph_msgs::Clock clock;
    clock.clock = stampOf(time);
    clock_.publish(clock);
  }
}

void SimulatorNode::advanceTo(double time) {
  const Scenario& s = simulator_->scenario();
  for (; imu_time_ <= time && ros::ok(); imu_time_ += 1 / s.imu.rate) {
    pace(imu_time_);
    Eigen::Vector3d turn, acceleration;
    if (live_) {
      std::optional<geometry_msgs::Twist> command;
      {
        const std::lock_guard<std::mutex> lock(command_mutex_);
        std::swap(command, command_);
      }
      if (command) {
        try {
          flight_->command(imu_time_, {command->linear.x, command->linear.y, command->linear.z},
                           command->angular.z);
        } catch (const InputError& e) {
          ROS_WARN_THROTTLE(5, "cmd_vel is not used: %s", e.what());
        }
      }
      if (!flight_->advance(imu_time_))
        ROS_WARN_THROTTLE(5, "the robot stops, because a wall is in the way");
      turn = flight_->angularVelocity();
      acceleration = flight_->acceleration();
    } else {
      turn = s.path.angularVelocity(imu_time_);
      acceleration = s.path.acceleration(imu_time_);
    }
    if (!s.path_is_of_camera)
      imu_publisher_.publish(toImu(imu_->read(imu_time_, attitudeAt(imu_time_), turn, acceleration),
                                   stampOf(imu_time_), messages_->frames().base));
  }
  // The image lies between two IMU readings. The clock is moved to it, so that the stamp of the
  // image is not later than the clock.
  pace(time);
  if (live_) flight_->advance(time);
}

void SimulatorNode::publishImage(double time) {
  const bool wanted =
      image_.getNumSubscribers() + depth_.getNumSubscribers() + mask_.getNumSubscribers() > 0;
  const ros::Time stamp = stampOf(time);
  RecordedFrame frame;
  const bool arrived = simulator_->take(
      time, [this](double t) { return cameraAt(t); }, wanted, &frame);
  broadcaster_.sendTransform(messages_->odometryTransform(*frame.odometry, stamp).transforms);
  odometry_.publish(messages_->odometry(*frame.odometry, stamp));
  truth_.publish(messages_->truth(*frame.truth, stamp));
  if (!wanted || !arrived) return;
  ++images_;
  info_.publish(messages_->info(stamp));
  image_.publish(messages_->image(frame.color, stamp));
  if (depth_.getNumSubscribers() > 0) {
    depth_info_.publish(messages_->info(stamp));
    depth_.publish(messages_->depth(frame.depth, stamp));
  }
  if (mask_.getNumSubscribers() > 0) mask_.publish(messages_->mask(frame.mask, stamp));
}

void SimulatorNode::run() {
  epoch_ = simulated_clock_ ? ros::Time(1) : ros::Time::now();
  started_ = ros::WallTime::now();
  static_broadcaster_.sendTransform(messages_->mounting(stampOf(begin_)).transforms);
  initial_pose_.publish(messages_->initialPose(stampOf(begin_)));
  info_.publish(messages_->info(stampOf(begin_)));
  depth_info_.publish(messages_->info(stampOf(begin_)));
  const double period = 1 / simulator_->scenario().rate;
  for (size_t i = 0; ros::ok(); ++i) {
    const double time = begin_ + static_cast<double>(i) * period;
    if (time > endTime() + 1e-6) break;
    advanceTo(time);
    const double late = (ros::WallTime::now() - started_).toSec() * speed_ - (time - begin_);
    // With the wall clock an image must not come later than its stamp says. An image that is late
    // by a period or more is left out.
    if (simulated_clock_ || speed_ == 0 || late < period) publishImage(time);
  }
  ROS_INFO("%zu images published", images_);
}

}  // namespace edge_mcl
