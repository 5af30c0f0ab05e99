#include "edge_mcl/nodes/bags/bag_set.h"

#include <algorithm>
#include <fstream>
#include <set>

#include "edge_mcl/core/base/error.h"

namespace edge_mcl {

namespace {

/// @throws InputError
std::unique_ptr<rosbag::Bag> opened(const std::string& file) {
  auto bag = std::make_unique<rosbag::Bag>();
  try {
    bag->open(file, rosbag::bagmode::Read);
    // A bag that was cut off opens, but has no messages.
    rosbag::View all(*bag);
    all.size();
    return bag;
  } catch (const rosbag::BagUnindexedException&) {
    throw InputError(file +
                     ": the bag was not closed: its recorder still runs or was killed; make "
                     "its index with `rosbag reindex " +
                     file + "`");
  } catch (const rosbag::BagException& e) {
    std::ifstream in(file, std::ios::binary);
    std::string head(7, '\0');
    in.read(head.data(), static_cast<std::streamsize>(head.size()));
    throw InputError(
        file + ": cannot be read as a bag: " + e.what() +
        (head == "#ROSBAG" ? "; if it was cut off, `rosbag reindex " + file + "` repairs it" : ""));
  } catch (const std::exception& e) {
    throw InputError(file + ": cannot be read as a bag: " + e.what());
  }
}

}  // namespace

BagSet::BagSet(const std::vector<std::string>& files) {
  for (const std::string& file : files) bags_.push_back(opened(file));
}

std::unique_ptr<rosbag::View> BagSet::view(const std::vector<std::string>& topics) const {
  auto result = std::make_unique<rosbag::View>();
  for (const auto& bag : bags_) result->addQuery(*bag, rosbag::TopicQuery(topics));
  return result;
}

std::unique_ptr<rosbag::View> BagSet::view() const {
  auto result = std::make_unique<rosbag::View>();
  for (const auto& bag : bags_) result->addQuery(*bag);
  return result;
}

std::vector<std::string> BagSet::topicsOf(const std::vector<std::string>& types) const {
  std::set<std::string> topics;
  for (const rosbag::ConnectionInfo* c : view()->getConnections())
    if (std::find(types.begin(), types.end(), c->datatype) != types.end()) topics.insert(c->topic);
  return {topics.begin(), topics.end()};
}

std::string BagSet::recordedTopic(const std::string& topic) const {
  for (const char* form : {"", "/compressed", "/compressedDepth"})
    if (has(topic + form)) return topic + form;
  return topic;
}

}  // namespace edge_mcl
