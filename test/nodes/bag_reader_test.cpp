// Tests that bags of other people's drivers and recorders are read. The bags are written here, with
// one thing changed in each, and the plain bag is the truth.
#include "edge_mcl/nodes/bags/bag_reader.h"

#include <gtest/gtest.h>
#include <rosbag/bag.h>
#include <rosbag/view.h>
#include <sensor_msgs/CompressedImage.h>

#include <filesystem>
#include <fstream>
#include <functional>
#include <opencv2/imgcodecs.hpp>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/nodes/bags/bag_writer.h"
#include "edge_mcl/nodes/messages/image_messages.h"
#include "edge_mcl/nodes/messages/recording_messages.h"
#include "edge_mcl/nodes/messages/ros_conversions.h"
#include "support/error_text.h"

namespace edge_mcl {
namespace {

namespace fs = std::filesystem;

constexpr int kImages = 4;
constexpr double kStart = 1600000000;  // s
const char* const kImageTopic = "/camera/image_raw";

CameraModel camera() {
  const std::vector<double> d{-0.1, 0.02, 0.001, 0, 0};
  return CameraModel::fromFields(40, 30, {30, 0, 20, 0, 31, 15, 0, 0, 1}, "plumb_bob", d.data(),
                                 d.size(), "test");
}

/// Image number i: grey, with one bright column.
cv::Mat imageOfNumber(int i) {
  cv::Mat image(30, 40, CV_8UC3, cv::Scalar(40, 50, 60));
  image.col(3 + 5 * i).setTo(cv::Scalar(200, 180, 160));
  return image;
}

class OtherBags : public testing::Test {
 protected:
  void SetUp() override {
    root_ = fs::path(testing::TempDir()) /
            testing::UnitTest::GetInstance()->current_test_info()->name();
    fs::remove_all(root_);
    fs::create_directories(root_);
    RecordingSetup setup;
    setup.camera = camera();
    BagWriter writer(path("plain.bag"), setup);
    for (int i = 0; i < kImages; ++i) {
      RecordedFrame frame;
      frame.time = kStart + 0.1 * i;
      frame.color = imageOfNumber(i);
      frame.odometry = Pose::Identity();
      frame.odometry->translation().x() = 0.2 * i;
      writer.write(frame);
    }
    writer.close();
  }
  void TearDown() override { fs::remove_all(root_); }
  std::string path(const std::string& name) const { return (root_ / name).string(); }

  struct Message {
    std::string topic;
    ros::Time time;
  };
  using Change = std::function<void(const rosbag::MessageInstance&, rosbag::Bag*)>;
  /// Writes the plain bag with changes. @param change writes what it wants of a message
  std::string changed(const std::string& name, const Change& change) const {
    rosbag::Bag from(path("plain.bag")), to(path(name), rosbag::bagmode::Write);
    rosbag::View all(from);
    for (const rosbag::MessageInstance& m : all) change(m, &to);
    return path(name);
  }
  template <class Type>
  static bool changeIf(const rosbag::MessageInstance& m, rosbag::Bag* to,
                       const std::function<void(Type*)>& change) {
    const auto message = m.instantiate<Type>();
    if (!message) return false;
    Type copy = *message;
    change(&copy);
    to->write(m.getTopic(), m.getTime(), copy);
    return true;
  }
  static void keep(const rosbag::MessageInstance& m, rosbag::Bag* to) {
    to->write(m.getTopic(), m.getTime(), m);
  }

  struct Content {
    std::vector<LiveInput> moments;
    std::vector<std::string> notes;
  };
  Content read(const std::vector<std::string>& files, const BagTopics& topics = {},
               const std::optional<CameraModel>& given = std::nullopt) const {
    BagReader reader(files, topics, given);
    Content content;
    LiveInput input;
    std::string problem;
    while (reader.next(&input, &problem)) {
      EXPECT_EQ(problem, "");
      content.moments.push_back(input);
    }
    content.notes = reader.notes();
    return content;
  }
  /// Expects the moments of the plain bag. @param tolerance of the pixels.
  void expectPlain(const Content& content, int tolerance = 0) const {
    const Content plain = read({path("plain.bag")});
    ASSERT_EQ(content.moments.size(), plain.moments.size());
    for (size_t i = 0; i < plain.moments.size(); ++i) {
      const LiveInput &a = content.moments[i], &b = plain.moments[i];
      EXPECT_NEAR(a.time, b.time, 1e-6);
      ASSERT_TRUE(a.odometry && b.odometry) << i;
      EXPECT_TRUE(a.odometry->isApprox(*b.odometry, 1e-9));
      ASSERT_EQ(a.images.size(), 1u) << i;
      EXPECT_LE(cv::norm(a.images[0].image, b.images[0].image, cv::NORM_INF), tolerance);
      EXPECT_TRUE(a.images[0].T_base_camera.isApprox(b.images[0].T_base_camera, 1e-9));
      EXPECT_EQ(a.images[0].camera.coefficients, b.images[0].camera.coefficients);
    }
  }
  static bool anyNote(const Content& content, const std::string& part) {
    return std::any_of(content.notes.begin(), content.notes.end(), [&](const std::string& note) {
      return note.find(part) != std::string::npos;
    });
  }
  fs::path root_;
};

TEST_F(OtherBags, CompressedImages) {
  for (const std::string format : {"png", "jpg"}) {
    const std::string file = changed(format + ".bag", [&](const auto& m, rosbag::Bag* to) {
      const auto image = m.template instantiate<sensor_msgs::Image>();
      if (!image) return keep(m, to);
      sensor_msgs::CompressedImage compressed;
      compressed.header = image->header;
      compressed.format = "bgr8; " + format + " compressed bgr8";
      cv::imencode("." + format, fromMessage(image, "test"), compressed.data,
                   {cv::IMWRITE_JPEG_QUALITY, 100});
      to->write(m.getTopic() + "/compressed", m.getTime(), compressed);
    });
    // JPEG changes colours between the columns by some values.
    const int tolerance = format == "png" ? 0 : 90;
    expectPlain(read({file}), tolerance);
    BagTopics topics;
    topics.image = std::string(kImageTopic) + "/compressed";
    expectPlain(read({file}, topics), tolerance);
  }
}

TEST_F(OtherBags, FramesWithASlash) {
  const auto slash = [](std::string* frame) { *frame = "/" + *frame; };
  const std::string file = changed("slash.bag", [&](const auto& m, rosbag::Bag* to) {
    if (changeIf<tf2_msgs::TFMessage>(m, to, [&](tf2_msgs::TFMessage* message) {
          for (auto& t : message->transforms) {
            slash(&t.header.frame_id);
            slash(&t.child_frame_id);
          }
        }))
      return;
    if (!changeIf<sensor_msgs::Image>(
            m, to, [&](sensor_msgs::Image* image) { slash(&image->header.frame_id); }))
      keep(m, to);
  });
  expectPlain(read({file}));
  BagTopics topics;
  topics.odom_frame = "/odom";
  topics.base_frame = "/base_link";
  expectPlain(read({file}, topics));
}

TEST_F(OtherBags, ASplitRecordingIsOne) {
  const ros::Time middle(kStart + 0.15);
  const std::string first = changed("first.bag", [&](const auto& m, rosbag::Bag* to) {
    if (m.getTime() < middle) keep(m, to);
  });
  const std::string second = changed("second.bag", [&](const auto& m, rosbag::Bag* to) {
    if (m.getTime() >= middle) keep(m, to);
  });
  expectPlain(read({second, first}));
}

TEST_F(OtherBags, ACalibrationFileTakesThePlaceOfCameraInfo) {
  const std::string file = changed("no_info.bag", [&](const auto& m, rosbag::Bag* to) {
    if (m.getTopic() != "/camera/camera_info") keep(m, to);
  });
  expectPlain(read({file}, {}, camera()));
  const std::string error = test::errorText<InputError>([&] { read({file}); });
  EXPECT_NE(error.find("--camera"), std::string::npos) << error;
}

TEST_F(OtherBags, WithoutTfTheCameraIsTheBase) {
  const std::string file = changed("no_tf.bag", [&](const auto& m, rosbag::Bag* to) {
    if (m.getTopic() != "/tf" && m.getTopic() != "/tf_static" && m.getTopic() != "/odom")
      keep(m, to);
  });
  const Content content = read({file});
  ASSERT_EQ(content.moments.size(), static_cast<size_t>(kImages));
  for (const LiveInput& moment : content.moments) {
    EXPECT_TRUE(moment.images[0].T_base_camera.isApprox(Pose::Identity()));
    EXPECT_FALSE(moment.odometry);
  }
  EXPECT_TRUE(anyNote(content, "the camera itself")) << content.notes.size();
}

TEST_F(OtherBags, WithoutAFrameTheOnlyOpticalFrameIsTaken) {
  const std::string file = changed("nameless.bag", [&](const auto& m, rosbag::Bag* to) {
    if (!changeIf<sensor_msgs::Image>(m, to,
                                      [](sensor_msgs::Image* i) { i->header.frame_id = ""; }))
      keep(m, to);
  });
  const Content content = read({file});
  expectPlain(content);
  EXPECT_TRUE(anyNote(content, "camera_optical"));
}

TEST_F(OtherBags, WithoutAFrameTheCameraIsTheBase) {
  const std::string file = changed("empty_frame.bag", [&](const auto& m, rosbag::Bag* to) {
    if (m.getTopic() == "/tf_static") {
      changeIf<tf2_msgs::TFMessage>(m, to, [](tf2_msgs::TFMessage* message) {
        message->transforms[0].child_frame_id = "cam0";
      });
      return;
    }
    if (!changeIf<sensor_msgs::Image>(m, to,
                                      [](sensor_msgs::Image* i) { i->header.frame_id = ""; }))
      keep(m, to);
  });
  const Content content = read({file});
  EXPECT_TRUE(content.moments[0].images[0].T_base_camera.isApprox(Pose::Identity()));
  EXPECT_FALSE(content.moments[1].odometry);  // it is the odometry of another body
  EXPECT_TRUE(anyNote(content, "camera_frame")) << content.notes.size();
  BagTopics topics;
  topics.camera_frame = "cam0";
  expectPlain(read({file}, topics));
}

TEST_F(OtherBags, AFrameWithTheAxesOfABodyIsNamed) {
  const std::string file = changed("gazebo.bag", [&](const auto& m, rosbag::Bag* to) {
    if (m.getTopic() != "/tf_static") return keep(m, to);
    changeIf<tf2_msgs::TFMessage>(m, to, [](tf2_msgs::TFMessage* message) {
      message->transforms[0].transform.rotation = geometry_msgs::Quaternion();
      message->transforms[0].transform.rotation.w = 1;
    });
  });
  EXPECT_TRUE(anyNote(read({file}), "static_transform_publisher"));
  EXPECT_FALSE(anyNote(read({path("plain.bag")}), "static_transform_publisher"));
}

/// The calibration of rectified images is P.
TEST_F(OtherBags, RectifiedImages) {
  const std::string file = changed("rect.bag", [&](const auto& m, rosbag::Bag* to) {
    if (m.getTopic() == kImageTopic)
      return to->write("/camera/image_rect", m.getTime(),
                       *m.template instantiate<sensor_msgs::Image>());
    if (!changeIf<sensor_msgs::CameraInfo>(m, to, [](sensor_msgs::CameraInfo* info) {
          info->P = {28, 0, 19, 0, 0, 29, 14, 0, 0, 0, 1, 0};
        }))
      keep(m, to);
  });
  const auto cameraOf = [&](const char* rectified) {
    BagTopics topics;
    topics.image = "/camera/image_rect";
    topics.rectified = rectified;
    return read({file}, topics).moments[0].images[0].camera;
  };
  for (const char* rectified : {"auto", "true"}) {
    EXPECT_EQ(cameraOf(rectified).fx, 28);
    EXPECT_EQ(cameraOf(rectified).distortion, DistortionModel::kNone);
  }
  EXPECT_EQ(cameraOf("false").fx, 30);
  EXPECT_EQ(cameraOf("false").distortion, DistortionModel::kPlumbBob);
  // It is the only topic of images, so it is found.
  EXPECT_TRUE(anyNote(read({file}), "/camera/image_rect"));
}

/// The image is the part at (8, 6) of 24 x 20 pixels, with 2 x 2 pixels joined. The truth is
/// image_geometry, PinholeCameraModel::fromCameraInfo.
TEST_F(OtherBags, RegionOfInterestAndBinning) {
  const std::string file = changed("roi.bag", [&](const auto& m, rosbag::Bag* to) {
    if (!changeIf<sensor_msgs::CameraInfo>(m, to, [](sensor_msgs::CameraInfo* info) {
          info->roi.x_offset = 8;
          info->roi.y_offset = 6;
          info->roi.width = 24;
          info->roi.height = 20;
          info->binning_x = info->binning_y = 2;
        }))
      keep(m, to);
  });
  const CameraModel part = read({file}).moments[0].images[0].camera;
  EXPECT_EQ(part.width, 12);
  EXPECT_EQ(part.height, 10);
  EXPECT_EQ(part.fx, 15);
  EXPECT_EQ(part.cx, (20 - 8) / 2.0);
  EXPECT_EQ(part.cy, (15 - 6) / 2.0);
}

TEST_F(OtherBags, ImagesWithoutAStampHaveTheTimeOfTheirRecording) {
  const std::string file = changed("zero.bag", [&](const auto& m, rosbag::Bag* to) {
    if (!changeIf<sensor_msgs::Image>(m, to,
                                      [](sensor_msgs::Image* i) { i->header.stamp = ros::Time(); }))
      keep(m, to);
  });
  const Content content = read({file});
  expectPlain(content);
  EXPECT_TRUE(anyNote(content, "without a stamp"));
}

TEST_F(OtherBags, ACameraWithAClockOfItsOwnIsShifted) {
  const std::string file = changed("clock.bag", [&](const auto& m, rosbag::Bag* to) {
    if (!changeIf<sensor_msgs::Image>(
            m, to, [](sensor_msgs::Image* i) { i->header.stamp += ros::Duration(153.2); }))
      keep(m, to);
  });
  const Content content = read({file});
  expectPlain(content);
  EXPECT_TRUE(anyNote(content, "153.2 s ahead"));
}

/// A stale first image says nothing of the clock of the others.
TEST_F(OtherBags, OneWrongStampIsNoOtherClock) {
  for (const double offset : {-6.0, 9.0, 1000.0}) {
    bool is_first = true;
    const std::string file = changed("stale.bag", [&](const auto& m, rosbag::Bag* to) {
      if (!changeIf<sensor_msgs::Image>(m, to, [&](sensor_msgs::Image* i) {
            if (is_first) i->header.stamp += ros::Duration(offset);
            is_first = false;
          }))
        keep(m, to);
    });
    const Content content = read({file});
    EXPECT_FALSE(anyNote(content, "clock"));
    EXPECT_NEAR(content.moments[1].time, kStart + 0.1, 1e-6);
  }
}

TEST_F(OtherBags, AnImageThatCannotBeDecodedKeepsItsTime) {
  int number = 0;
  const std::string file = changed("broken.bag", [&](const auto& m, rosbag::Bag* to) {
    const auto image = m.template instantiate<sensor_msgs::Image>();
    if (!image) return keep(m, to);
    sensor_msgs::CompressedImage compressed;
    compressed.header = image->header;
    compressed.format = "jpeg";
    cv::imencode(".jpg", fromMessage(image, "test"), compressed.data);
    if (number++ == 1) compressed.data.assign(50, 7);
    // It is recorded late, as over a network.
    to->write(m.getTopic() + "/compressed", m.getTime() + ros::Duration(0.3), compressed);
  });
  BagReader reader({file}, {});
  LiveInput input;
  std::string problem;
  for (int i = 0; i < kImages; ++i) {
    ASSERT_TRUE(reader.next(&input, &problem));
    EXPECT_NEAR(input.time, kStart + 0.1 * i, 1e-6);
    EXPECT_EQ(problem.empty(), i != 1) << problem;
  }
}

TEST_F(OtherBags, TheFirstCalibrationThatCanBeUsedCounts) {
  int number = 0;
  const std::string file = changed("late.bag", [&](const auto& m, rosbag::Bag* to) {
    if (!changeIf<sensor_msgs::CameraInfo>(m, to, [&](sensor_msgs::CameraInfo* info) {
          if (number++ < 2) info->K.fill(0);
        }))
      keep(m, to);
  });
  expectPlain(read({file}));
}

TEST_F(OtherBags, RectifiedImagesHaveNoDistortionOfAFile) {
  const std::string file = changed("rect_file.bag", [&](const auto& m, rosbag::Bag* to) {
    if (m.getTopic() == kImageTopic)
      return to->write("/camera/image_rect_color", m.getTime(),
                       *m.template instantiate<sensor_msgs::Image>());
    keep(m, to);
  });
  const Content content = read({file}, {}, camera());
  EXPECT_EQ(content.moments[0].images[0].camera.distortion, DistortionModel::kNone);
  EXPECT_TRUE(anyNote(content, "rectified=false"));
}

TEST(RectifiedTopics, RectIsAWordOfTheName) {
  for (const char* topic : {"/camera/image_rect", "/cam/image_rect_color", "/rgb/rect/image",
                            "/zed/rgb/image_rect_gray", "/left/rectified"})
    EXPECT_TRUE(isRectifiedTopic(topic)) << topic;
  for (const char* topic : {"/camera/image_raw", "/cam_rectangle/image_raw", "/direct/image"})
    EXPECT_FALSE(isRectifiedTopic(topic)) << topic;
}

TEST_F(OtherBags, WhatIsNoClosedBagSaysWhatToDo) {
  std::ifstream in(path("plain.bag"), std::ios::binary);
  std::string bytes((std::istreambuf_iterator<char>(in)), {});
  const auto at = bytes.find("index_pos=");
  bytes.replace(at + 10, 8, 8, '\0');
  std::ofstream(path("killed.bag.active"), std::ios::binary) << bytes.substr(0, bytes.size() / 2);
  const std::string error = test::errorText<InputError>([&] { read({path("killed.bag.active")}); });
  EXPECT_NE(error.find("rosbag reindex"), std::string::npos) << error;
}

}  // namespace
}  // namespace edge_mcl
