/// One or several bags of one recording, read as one.
#pragma once

#include <rosbag/bag.h>
#include <rosbag/view.h>

#include <memory>
#include <string>
#include <vector>

namespace edge_mcl {

/// `rosbag record --split` writes a recording in parts. The order of the files does not matter.
class BagSet {
 public:
  /// @throws InputError that says what to do when a file is not a bag or was not closed
  explicit BagSet(const std::vector<std::string>& files);

  /// Messages of the topics in all bags, by the time of recording.
  std::unique_ptr<rosbag::View> view(const std::vector<std::string>& topics) const;
  /// All messages.
  std::unique_ptr<rosbag::View> view() const;

  /// Topics that hold messages of one of the types, in alphabetical order.
  std::vector<std::string> topicsOf(const std::vector<std::string>& types) const;
  /// Topics that hold raw or compressed images.
  std::vector<std::string> imageTopics() const {
    return topicsOf({"sensor_msgs/Image", "sensor_msgs/CompressedImage"});
  }
  bool has(const std::string& topic) const { return view({topic})->size() > 0; }
  /// The topic that holds the images of a topic: the topic itself, or its compressed form when
  /// there is only that. @return `topic` when there is neither
  std::string recordedTopic(const std::string& topic) const;

 private:
  std::vector<std::unique_ptr<rosbag::Bag>> bags_;
};

}  // namespace edge_mcl
