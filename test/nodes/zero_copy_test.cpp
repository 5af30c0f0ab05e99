/// The nodelet must use the very image objects that their publisher made, without a copy. This
/// shows from outside: while an image waits for its mask, the localizer owns a share of it.
#include <gtest/gtest.h>
#include <nodelet/loader.h>
#include <ros/ros.h>
#include <sensor_msgs/CameraInfo.h>
#include <sensor_msgs/Image.h>
#include <sensor_msgs/image_encodings.h>

#include <chrono>
#include <functional>
#include <string>
#include <thread>

#include "edge_mcl/nodes/messages/ros_conversions.h"

namespace edge_mcl {
namespace {

sensor_msgs::ImagePtr picture(const std::string& encoding, size_t pixel_size) {
  auto image = boost::make_shared<sensor_msgs::Image>();
  image->header.stamp = ros::Time(1);
  image->header.frame_id = "camera";
  image->encoding = encoding;
  image->width = 640;
  image->height = 480;
  image->step = static_cast<uint32_t>(640 * pixel_size);
  image->data.assign(static_cast<size_t>(image->step) * image->height, 7);
  return image;
}

bool within(double seconds, const std::function<bool()>& condition) {
  using Clock = std::chrono::steady_clock;
  const auto end = Clock::now() + std::chrono::duration<double>(seconds);
  while (!condition() && Clock::now() < end)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  return condition();
}

class ZeroCopy : public ::testing::Test {
 protected:
  void SetUp() override {
    ros::NodeHandle private_nh("/localizer");
    private_nh.setParam("model_file", std::string(getenv("EDGE_MCL_MAPS")) + "/office.obj");
    private_nh.setParam("tf_broadcast", false);
    private_nh.setParam("use_masks", true);
    private_nh.setParam("mask_policy", "skip_update");
    private_nh.setParam("mask_timeout", 3600.0);  // the images of this test wait for ever
    private_nh.setParam("likelihood/cues", "both");
    ASSERT_TRUE(loader_.load("/localizer", "edge_mcl/Localizer", {}, {}));
  }

  /// Publishes and waits for one second, so that all subscribers have the message. @return number
  /// of owners of `image` besides this test
  template <typename Published>
  static long othersAfterPublishing(const ros::Publisher& publisher,
                                    const sensor_msgs::ImagePtr& image,
                                    const Published& published) {
    publisher.publish(published);
    std::this_thread::sleep_for(std::chrono::seconds(1));
    return image.use_count() - 1;
  }

  nodelet::Loader loader_{false};
};

/// As a control, an image that is published as a copy gets no further owner.
TEST_F(ZeroCopy, TheLocalizerKeepsThePublishersImages) {
  ros::NodeHandle nh;
  for (const auto& [topic, encoding, pixel_size] :
       {std::tuple{"image", "bgr8", 3}, std::tuple{"depth", "32FC1", 4},
        std::tuple{"mask", "mono8", 1}}) {
    SCOPED_TRACE(topic);
    const ros::Publisher publisher = nh.advertise<sensor_msgs::Image>(topic, 1);
    ASSERT_TRUE(within(10, [&] { return publisher.getNumSubscribers() > 0; }));
    const sensor_msgs::ImagePtr copied = picture(encoding, static_cast<size_t>(pixel_size));
    EXPECT_EQ(othersAfterPublishing(publisher, copied, *copied), 0) << "the control";
    const sensor_msgs::ImagePtr shared = picture(encoding, static_cast<size_t>(pixel_size));
    // The stamp differs from those of other topics, so that no image is complete.
    shared->header.stamp = ros::Time(std::string(topic) == "mask" ? 50 : 2);
    EXPECT_GE(othersAfterPublishing(publisher, shared, shared), 1);
  }
}

/// The converted image must point to the pixels of the message.
TEST(RosConversions, SharesThePixels) {
  namespace encodings = sensor_msgs::image_encodings;
  for (const auto& [encoding, size] : {std::pair{encodings::BGR8, 3}, {encodings::MONO8, 1}}) {
    const sensor_msgs::ImagePtr image = picture(encoding, static_cast<size_t>(size));
    EXPECT_EQ(fromMessage(image, "").data, image->data.data()) << encoding;
  }
  for (const auto& [encoding, size] :
       {std::pair{encodings::TYPE_32FC1, 4}, {encodings::TYPE_16UC1, 2}, {encodings::MONO16, 2}}) {
    const sensor_msgs::ImagePtr image = picture(encoding, static_cast<size_t>(size));
    EXPECT_EQ(depthFromMessage(image, "").data, image->data.data()) << encoding;
  }
  const sensor_msgs::ImagePtr mask = picture(encodings::MONO8, 1);
  EXPECT_EQ(maskFromMessage(mask, "").data, mask->data.data());
}

}  // namespace
}  // namespace edge_mcl

int main(int argc, char** argv) {
  ::testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, "zero_copy_test");
  ros::NodeHandle keep_alive;
  ros::AsyncSpinner spinner(2);
  spinner.start();
  return RUN_ALL_TESTS();
}
