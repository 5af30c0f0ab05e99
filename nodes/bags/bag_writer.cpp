#include "edge_mcl/nodes/bags/bag_writer.h"

#include <rosbag/bag.h>

#include <filesystem>
#include <optional>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/nodes/messages/recording_messages.h"
#include "edge_mcl/nodes/messages/ros_conversions.h"

namespace edge_mcl {

struct BagWriter::Impl {
  std::string file;
  RecordingMessages messages;
  std::unique_ptr<rosbag::Bag> bag;
  std::optional<double> offset;  // added to the recording's times, s; none before the first
  bool begun = false;
  size_t count = 0;

  std::string active() const { return file + ".active"; }

  [[noreturn]] void fail(const std::exception& e) {
    // The bag object is not destroyed: its destructor would write the index, fail again and end the
    // program. The system closes the file.
    static_cast<void>(bag.release());
    throw InputError(active() + ": cannot be written (disk full?): " + e.what() + "; about " +
                     std::to_string(count) +
                     " images are in it, which `rosbag reindex` makes readable");
  }

  ros::Time timeOf(double seconds) {
    constexpr double kEarliest = 1;
    if (!offset) offset = seconds < kEarliest ? kEarliest : 0;
    if (!(seconds + *offset > 0))
      throw InputError(file + ": time " + std::to_string(seconds) + " s is too early for a bag");
    ros::Time time;
    // Rounded to the microsecond, as in the text files of a sequence.
    const auto micro = static_cast<uint64_t>(std::llround((seconds + *offset) * 1e6));
    return time.fromNSec(micro * 1000);
  }

  template <class Message>
  void put(const std::string& topic, const ros::Time& time, const Message& message) {
    try {
      if (!bag) throw Error("the bag is closed");
      bag->write("/" + topic, time, message);
    } catch (const std::exception& e) {
      fail(e);
    }
  }

  /// Writes a latched message, which a player also sends to nodes that subscribe later.
  template <class Message>
  void putLatched(const std::string& topic, const ros::Time& time, const Message& message) {
    namespace traits = ros::message_traits;
    const auto connection = boost::make_shared<ros::M_string>(
        ros::M_string{{"topic", "/" + topic},
                      {"type", traits::datatype<Message>()},
                      {"md5sum", traits::md5sum<Message>()},
                      {"message_definition", traits::definition<Message>()},
                      {"latching", "1"},
                      {"callerid", "/edge_mcl"}});
    try {
      if (!bag) throw Error("the bag is closed");
      bag->write("/" + topic, time, message, connection);
    } catch (const std::exception& e) {
      fail(e);
    }
  }

  void begin(const ros::Time& time) {
    if (begun) return;
    begun = true;
    putLatched("tf_static", time, messages.mounting(time));
    putLatched(recording_topics::kInitialPose, time, messages.initialPose(time));
  }
};

BagWriter::BagWriter(const std::string& file, const RecordingSetup& setup)
    : impl_(
          new Impl{file, RecordingMessages(setup), std::make_unique<rosbag::Bag>(), {}, false, 0}) {
  std::error_code ignored;
  if (std::filesystem::exists(file, ignored)) throw InputError(file + ": exists already");
  try {
    impl_->bag->open(impl_->active(), rosbag::bagmode::Write);
    impl_->bag->setCompression(rosbag::compression::LZ4);
  } catch (const std::exception& e) {
    throw InputError(file + ": cannot be written: " + e.what());
  }
}

BagWriter::~BagWriter() {
  try {
    close();
  } catch (const std::exception&) {  // a destructor must not throw; close() reports faults
  }
}

size_t BagWriter::count() const { return impl_->count; }

void BagWriter::write(const RecordedFrame& frame) {
  namespace topics = recording_topics;
  Impl& m = *impl_;
  const ros::Time time = m.timeOf(frame.time);
  m.begin(time);
  if (frame.odometry) {
    m.put("tf", time, m.messages.odometryTransform(*frame.odometry, time));
    m.put(topics::kOdometry, time, m.messages.odometry(*frame.odometry, time));
  }
  if (frame.truth) m.put(topics::kTruth, time, m.messages.truth(*frame.truth, time));
  if (!frame.depth.empty()) writeDepth(frame.time, frame.depth);
  if (!frame.mask.empty()) m.put(topics::kMask, time, *m.messages.mask(frame.mask, time));
  m.put(topics::kInfo, time, m.messages.info(time));
  m.put(topics::kImage, time, *m.messages.image(frame.color, time));
  ++m.count;
}

void BagWriter::writeDepth(double time, const cv::Mat& depth) {
  Impl& m = *impl_;
  const ros::Time stamp = m.timeOf(time);
  m.begin(stamp);
  m.put(recording_topics::kDepth, stamp, *m.messages.depth(depth, stamp));
  m.put(recording_topics::kDepthInfo, stamp, m.messages.info(stamp));
}

void BagWriter::writeImu(const std::vector<ImuReading>& readings) {
  for (const ImuReading& r : readings) {
    const ros::Time time = impl_->timeOf(r.time);
    impl_->put(recording_topics::kImu, time, toImu(r, time, impl_->messages.frames().base));
  }
}

void BagWriter::close() {
  Impl& m = *impl_;
  if (!m.bag) return;
  try {
    m.bag->close();
  } catch (const std::exception& e) {
    m.fail(e);
  }
  m.bag.reset();
  std::error_code error;
  std::filesystem::rename(m.active(), m.file, error);
  if (error) throw InputError(m.file + ": cannot be written: " + error.message());
}

}  // namespace edge_mcl
