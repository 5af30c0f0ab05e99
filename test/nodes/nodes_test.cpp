#include <gtest/gtest.h>

#include <ros/time.h>
#include <sys/resource.h>
#include <boost/make_shared.hpp>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <opencv2/core.hpp>
#include <random>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/base/parameter_struct.h"
#include "edge_mcl/core/camera/mask_motion.h"
#include "edge_mcl/nodes/bags/bag_writer.h"
#include "edge_mcl/nodes/common/patience.h"
#include "edge_mcl/nodes/localizer/mask_matcher.h"
#include "edge_mcl/nodes/localizer/node_parameters.h"
#include "edge_mcl/nodes/localizer/particle_file.h"
#include "edge_mcl/nodes/messages/recording_messages.h"
#include "edge_mcl/nodes/messages/ros_conversions.h"

namespace edge_mcl {
namespace {

Pose randomPose(std::mt19937* random) {
  std::normal_distribution<double> normal;
  Twist xi;
  for (int i = 0; i < 6; ++i) xi[i] = normal(*random);
  return expSe3(xi);
}

sensor_msgs::ImagePtr stamped(double seconds) {
  auto image = boost::make_shared<sensor_msgs::Image>();
  image->header.stamp = ros::Time(seconds);
  return image;
}

TEST(RosConversions, PosesComeBack) {
  std::mt19937 random(1);
  for (int i = 0; i < 100; ++i) {
    const Pose pose = randomPose(&random);
    EXPECT_TRUE(fromMessage(toPoseMessage(pose), "").isApprox(pose, 1e-12));
    EXPECT_TRUE(fromMessage(toTransformMessage(pose), "").isApprox(pose, 1e-12));
  }
}

/// The covariance of the message is the covariance of position and fixed-axis rotation in the map.
/// The truth is the sample covariance of many poses. Their rotations are small enough for the first
/// order.
TEST(RosConversions, CovarianceIsInMapAxes) {
  std::mt19937 random(2);
  std::normal_distribution<double> normal;
  PoseGaussian gaussian;
  gaussian.mean = randomPose(&random);
  Matrix6 root = Matrix6::Zero();
  for (int r = 0; r < 6; ++r)
    for (int c = 0; c <= r; ++c) root(r, c) = 0.01 * normal(random);
  gaussian.covariance = root * root.transpose();
  constexpr int kSamples = 20000;
  Matrix6 sampled = Matrix6::Zero();
  for (int i = 0; i < kSamples; ++i) {
    Twist white;
    for (int k = 0; k < 6; ++k) white[k] = normal(random);
    const Pose pose = gaussian.mean * expSe3(root * white);
    Twist difference;
    difference << pose.translation() - gaussian.mean.translation(),
        logSo3(pose.linear() * gaussian.mean.linear().transpose());
    sampled += difference * difference.transpose() / kSamples;
  }
  const geometry_msgs::PoseWithCovariance message = toPoseMessage(gaussian);
  for (int r = 0; r < 6; ++r)
    for (int c = 0; c < 6; ++c) {
      // The tolerance is four standard errors of a sample covariance, plus the second order (0.03
      // rad squared).
      const double error = 4 * std::sqrt(2.0 / kSamples * sampled(r, r) * sampled(c, c));
      EXPECT_NEAR(message.covariance[6 * r + c], sampled(r, c),
                  error + 1e-3 * std::sqrt(sampled(r, r) * sampled(c, c)));
    }
  EXPECT_TRUE(fromMessage(message, "").covariance.isApprox(gaussian.covariance, 1e-9));
}

TEST(RosConversions, BadPosesAreRefused) {
  geometry_msgs::PoseWithCovariance message = toPoseMessage(PoseGaussian());
  auto bad = message;
  bad.pose.position.y = NAN;
  EXPECT_THROW(fromMessage(bad, "x"), InputError);
  bad = message;
  bad.pose.orientation.w = 0;
  EXPECT_THROW(fromMessage(bad, "x"), InputError);
  bad = message;
  bad.covariance[0] = -1;
  EXPECT_THROW(fromMessage(bad, "x"), InputError);
  bad = message;
  bad.covariance[1] = 1;
  EXPECT_THROW(fromMessage(bad, "x"), InputError);
  EXPECT_NO_THROW(fromMessage(message, "x"));
}

TEST(RosConversions, CameraComesBack) {
  for (const DistortionModel distortion :
       {DistortionModel::kPlumbBob, DistortionModel::kRationalPolynomial,
        DistortionModel::kEquidistant}) {
    CameraModel camera;
    camera.width = 640;
    camera.height = 480;
    camera.fx = 500;
    camera.fy = 510;
    camera.cx = 320;
    camera.cy = 241;
    camera.distortion = distortion;
    camera.coefficients = {0.01, -0.002, 0.0003, 0.0004, 0, 0, 0, 0};
    const CameraModel back = fromMessage(toCameraInfo(camera, ros::Time(1), "c"), "");
    EXPECT_EQ(back.distortion, distortion);
    EXPECT_EQ(back.coefficients, camera.coefficients);
    EXPECT_EQ(back.fy, camera.fy);
    EXPECT_EQ(back.cx, camera.cx);
  }
}

/// An image in an encoding that robots send must come back with its pixels.
TEST(RosConversions, ImageEncodings) {
  const cv::Mat grey(8, 10, CV_8U, cv::Scalar(90)), color(8, 10, CV_8UC3, cv::Scalar(10, 90, 200)),
      deep(8, 10, CV_16U, cv::Scalar(90 * 257)),
      alpha(8, 10, CV_8UC4, cv::Scalar(10, 90, 200, 255));
  const auto read = [](const cv::Mat& image, const char* encoding) {
    // The pixels are not copied, so they live as long as the message.
    return fromMessage(toImage(image, encoding, ros::Time(1), ""), "test").clone();
  };
  EXPECT_EQ(read(grey, "mono8").at<uint8_t>(3, 3), 90);
  EXPECT_EQ(read(color, "bgr8").at<cv::Vec3b>(3, 3), cv::Vec3b(10, 90, 200));
  EXPECT_EQ(read(color, "rgb8").at<cv::Vec3b>(3, 3), cv::Vec3b(200, 90, 10));
  EXPECT_EQ(read(alpha, "bgra8").at<cv::Vec3b>(3, 3), cv::Vec3b(10, 90, 200));
  EXPECT_EQ(read(deep, "mono16").at<uint16_t>(3, 3), 90 * 257);
  // The pixels of common encodings are not copied.
  const sensor_msgs::ImagePtr message = toImage(color, "bgr8", ros::Time(1), "");
  EXPECT_EQ(fromMessage(message, "").data, message->data.data());
  EXPECT_EQ(maskFromMessage(toImage(grey, "mono8", ros::Time(1), ""), "").at<uint8_t>(0, 0), 90);
  EXPECT_THROW(maskFromMessage(message, ""), InputError);
}

TEST(MaskMatcher, WithoutMasksTheNewestImageWins) {
  MaskMatcher matcher(false, 1);
  EXPECT_FALSE(matcher.take(0));
  for (int i = 1; i <= 3; ++i) matcher.addImage(stamped(i), 0);
  EXPECT_EQ(matcher.take(0)->image->header.stamp.toSec(), 3);
  EXPECT_FALSE(matcher.take(0));
  EXPECT_EQ(matcher.dropped(), 2u);
}

/// An image waits for its mask, at most 0.5 s.
TEST(MaskMatcher, ImagesWaitForTheirMasks) {
  MaskMatcher matcher(true, 0.5);
  for (int i = 1; i <= 3; ++i) matcher.addImage(stamped(i), 0.1 * i);
  EXPECT_FALSE(matcher.take(0.4));
  matcher.addMask(stamped(2));
  const auto second = matcher.take(0.4);
  ASSERT_TRUE(second && second->mask);
  EXPECT_EQ(second->image->header.stamp.toSec(), 2);
  EXPECT_EQ(matcher.dropped(), 1u);
  EXPECT_FALSE(matcher.take(0.79));
  const auto third = matcher.take(0.81);  // it has waited for half a second
  ASSERT_TRUE(third);
  EXPECT_FALSE(third->mask);
  // A mask may come before its image.
  matcher.addMask(stamped(4));
  matcher.addImage(stamped(4), 1);
  EXPECT_TRUE(matcher.take(1)->mask);
}

TEST(MaskMatcher, ForgetsWhatWaitsWhenTheClockJumpsBack) {
  MaskMatcher matcher(true, 0.5);
  matcher.addImage(stamped(100), 0);
  matcher.addImage(stamped(10), 0.1);
  const auto match = matcher.take(0.7);
  ASSERT_TRUE(match);
  EXPECT_EQ(match->image->header.stamp.toSec(), 10);
  EXPECT_FALSE(matcher.take(10));
}

/// Another camera gives the time of the moment. The image of this time is taken, and newer images
/// wait for their own moments.
TEST(MaskMatcher, TakesTheImageOfAMoment) {
  MaskMatcher matcher(true, 0.5);
  const auto near = [&](double stamp, double now) {
    return matcher.takeNear(ros::Time(stamp), 0.02, now);
  };
  EXPECT_TRUE(near(1, 0).may_come);
  for (const double at : {1.01, 2.01, 3.01}) matcher.addImage(stamped(at), 0);
  const auto waiting = near(2, 0.1);
  EXPECT_FALSE(waiting.match);
  EXPECT_TRUE(waiting.waits_for_mask);
  matcher.addMask(stamped(2.01));
  const auto second = near(2, 0.1);
  ASSERT_TRUE(second.match && second.match->mask);
  EXPECT_EQ(second.match->image->header.stamp, ros::Time(2.01));
  EXPECT_EQ(matcher.dropped(), 1u);  // the image of 1.01 s
  const auto third = near(3, 0.6);
  ASSERT_TRUE(third.match);
  EXPECT_FALSE(third.match->mask);  // its mask was awaited for half a second
  // The image of 1 s was dropped, the image of 2.5 s is missing, the image of 4 s may still come.
  EXPECT_FALSE(near(1, 0.6).may_come);
  EXPECT_FALSE(near(2.5, 0.6).may_come);
  EXPECT_TRUE(near(4, 0.6).may_come);
  EXPECT_EQ(near(4, 0.6).newest, 3.01);
}

TEST(Patience, EndsWithTheFourthMissAndComesBackWithNews) {
  Patience patience;
  for (int i = 0; i < 4; ++i) {
    EXPECT_TRUE(patience.isWorthwhile(7));
    patience.missed(7, true);
  }
  EXPECT_FALSE(patience.isWorthwhile(7));
  patience.missed(7, false);
  EXPECT_TRUE(patience.isWorthwhile(8));
  EXPECT_TRUE(patience.isWorthwhile(1));  // a clock that jumped back
  patience.found();
  EXPECT_TRUE(patience.isWorthwhile(8));
}

/// The data always come too late. So hardly any image may wait for them.
TEST(Patience, TriesMoreAndMoreSeldom) {
  Patience patience;
  int waits = 0;
  for (int i = 0; i < 1000; ++i) {
    const bool waited = patience.isWorthwhile(i);
    waits += waited ? 1 : 0;
    patience.missed(i, waited);
  }
  EXPECT_LT(waits, 30);
  EXPECT_GT(waits, 10);
}

/// A camera with a sixth of the rate has no image for most moments. These moments must not wait.
TEST(MaskMatcher, KnowsWhenTheNextImageIsDue) {
  MaskMatcher matcher(false, 0);
  for (const double at : {1.0, 1.2, 1.4}) matcher.addImage(stamped(at), 0);
  EXPECT_TRUE(matcher.takeNear(ros::Time(1.4), 0.02, 0).match);
  for (const double at : {1.433, 1.467, 1.5, 1.533})
    EXPECT_FALSE(matcher.takeNear(ros::Time(at), 0.02, 0).may_come) << at;
  EXPECT_TRUE(matcher.takeNear(ros::Time(1.6), 0.02, 0).may_come);
}

TEST(MaskMatcher, DoesNotGrow) {
  MaskMatcher matcher(true, 1e9);
  for (int i = 1; i < 10000; ++i) matcher.addImage(stamped(i), i);
  EXPECT_GT(matcher.dropped(), 9900u);
}

/// The truth is the rays of the pixels: a turned mask covers the pixels where the rays of the mask
/// are after the turn.
TEST(MaskMotion, FollowsTheRays) {
  CameraModel camera;
  camera.width = 320;
  camera.height = 240;
  camera.fx = camera.fy = 220;
  camera.cx = 160;
  camera.cy = 120;
  camera.validate("");
  cv::Mat mask = cv::Mat::zeros(240, 320, CV_8U);
  mask(cv::Rect(150, 100, 40, 30)).setTo(255);
  const Eigen::Matrix3d turn = expSo3({0.05, -0.12, 0.08});
  const cv::Mat turned = turnMask(mask, camera, turn);
  int checked = 0;
  for (int y = 0; y < 240; y += 3)
    for (int x = 0; x < 320; x += 3) {
      const Eigen::Vector3d ray((x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy, 1);
      Eigen::Vector2d then;
      ASSERT_TRUE(camera.project(turn.transpose() * ray, &then));
      // Pixels within one pixel of the border are left out, because rounding decides about them.
      const double in = std::min({then.x() - 150, 189 - then.x(), then.y() - 100, 129 - then.y()});
      if (std::abs(in) < 1) continue;
      EXPECT_EQ(turned.at<uint8_t>(y, x) > 0, in > 0) << x << " " << y;
      ++checked;
    }
  EXPECT_GT(checked, 5000);
}

TEST(NodeParameters, BothKindsByName) {
  NodeParameters node;
  Parameters method;
  applyParameters({{"model_file", "a.obj"},
                   {"filter/particles", "77"},
                   {"update_min_a", "0.5"},
                   {"cameras", "front,left"},
                   {"initial_pose_a", "1.5"}},
                  &node, &method);
  EXPECT_EQ(method.filter.particles, 77);
  EXPECT_NEAR(method.tracking.update_min_a_deg, 0.5 * 180 / M_PI, 1e-9);
  EXPECT_EQ(node.cameraNames(), (std::vector<std::string>{"front", "left"}));
  EXPECT_TRUE(node.has_initial_pose);
  EXPECT_TRUE(node.initialPose().mean.linear().isApprox(
      Eigen::AngleAxisd(1.5, Eigen::Vector3d::UnitZ()).toRotationMatrix()));
}

TEST(NodeParameters, AllFaultsAtOnce) {
  NodeParameters node;
  Parameters method;
  try {
    applyParameters({{"model_fil", "a.obj"},
                     {"filter/particels", "3"},
                     {"mask_policy", "perhaps"},
                     {"likelihood/sigma", "-1"},
                     {"transform_tolerance", "soon"}},
                    &node, &method);
    FAIL() << "accepted";
  } catch (const ParameterError& e) {
    const std::string text = e.what();
    for (const char* part :
         {"~model_file'", "~filter/particles'", "perhaps", "likelihood.sigma", "'soon'"})
      EXPECT_NE(text.find(part), std::string::npos) << part << " in " << text;
  }
}

/// Plugins of image_transport and the diagnostics have parameters below the name of the node. They
/// are not parameters of the node.
TEST(NodeParameters, OfOtherLibrariesAreLeftAlone) {
  NodeParameters node;
  Parameters method;
  EXPECT_NO_THROW(applyParameters({{"model_file", "a.obj"},
                                   {"overlay/compressed/format", "jpeg"},
                                   {"overlay/theora/quality", "31"},
                                   {"compressed/mode", "unchanged"},
                                   {"diagnostic_period", "2"}},
                                  &node, &method));
}

/// docs/ros.md must list every parameter of the node.
TEST(NodeParameters, AreDocumented) {
  std::ifstream in(EDGE_MCL_DOCS "/ros.md");
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  for (const std::string& name : parameterNames(NodeParameters()))
    EXPECT_NE(text.find("`" + name + "`"), std::string::npos) << name;
}

/// A message must name the bits and channels of its image.
TEST(RecordingMessages, ImagesOfEveryKindAreNamedRightly) {
  const RecordingMessages messages({}, {});
  for (const auto& [type, encoding] : std::map<int, std::string>{{CV_8UC1, "mono8"},
                                                                 {CV_8UC3, "bgr8"},
                                                                 {CV_8UC4, "bgra8"},
                                                                 {CV_16UC1, "mono16"},
                                                                 {CV_16UC3, "bgr16"},
                                                                 {CV_16UC4, "bgra16"}}) {
    const cv::Mat image(6, 8, type, cv::Scalar::all(200));
    const auto message = messages.image(image, ros::Time(1));
    EXPECT_EQ(message->encoding, encoding);
    EXPECT_EQ(message->data.size(), image.total() * image.elemSize());
    EXPECT_EQ(fromMessage(message, "").size(), image.size());
  }
  EXPECT_THROW(messages.image(cv::Mat(6, 8, CV_32FC2), ros::Time(1)), InputError);
}

/// A limit on the size of files acts as a full disk. There must be one error and no crash, and the
/// data that were written must stay.
TEST(BagWriter, AFullDiskIsOneError) {
  const std::string file =
      (std::filesystem::temp_directory_path() / ("edge_mcl_full_" + std::to_string(getpid())))
          .string() +
      ".bag";
  const auto previous = std::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  rlimit small = before;
  small.rlim_cur = 4 << 20;
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  RecordingSetup setup;
  setup.camera.width = 320;
  setup.camera.height = 240;
  std::string fault;
  size_t written = 0;
  {
    BagWriter writer(file, setup);
    cv::Mat noise(240, 320, CV_8UC3);
    for (int i = 0; i < 200 && fault.empty(); ++i) {
      cv::randu(noise, 0, 256);
      RecordedFrame frame;
      frame.time = 10 + 0.1 * i;
      frame.color = noise;
      try {
        writer.write(frame);
      } catch (const InputError& e) {
        fault = e.what();
      }
    }
    written = writer.count();
    EXPECT_NO_THROW(writer.close());
  }
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, previous);
  EXPECT_NE(fault.find("disk full?"), std::string::npos) << fault;
  EXPECT_GT(written, 5u);
  EXPECT_FALSE(std::filesystem::exists(file));
  EXPECT_GT(std::filesystem::file_size(file + ".active"), 1u << 20);
  std::filesystem::remove(file + ".active");
}

TEST(ParticleFile, ComesBack) {
  const std::string file =
      (std::filesystem::temp_directory_path() / ("edge_mcl_particles_" + std::to_string(getpid())))
          .string();
  std::mt19937 random(3);
  ParticleSet particles;
  for (int i = 0; i < 50; ++i) {
    particles.poses.push_back(randomPose(&random));
    particles.log_weights.push_back(-i / 7.0);
  }
  writeParticles(file, particles);
  const ParticleSet back = readParticles(file);
  ASSERT_EQ(back.poses.size(), 50u);
  for (int i = 0; i < 50; ++i) {
    // The file has nine decimals.
    EXPECT_TRUE(back.poses[i].isApprox(particles.poses[i], 1e-8));
    EXPECT_DOUBLE_EQ(back.log_weights[i], particles.log_weights[i]);
  }
  std::filesystem::remove(file);
}

}  // namespace
}  // namespace edge_mcl
