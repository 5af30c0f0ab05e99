#include "apps/recordings/recorder_choice.h"

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/mrpt_plugins/rawlog_export.h"
#ifdef EDGE_MCL_HAS_ROS
#include "edge_mcl/nodes/bags/bag_writer.h"
#endif

namespace edge_mcl {

namespace {

bool endsWith(const std::string& text, const std::string& end) {
  return text.size() > end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

}  // namespace

std::unique_ptr<Recorder> recorderForFile(const std::string& file, const RecordingSetup& setup,
                                          const FilterParameters& noise) {
  if (endsWith(file, ".rawlog")) return std::make_unique<RawlogWriter>(file, setup, noise);
  if (!endsWith(file, ".bag")) return nullptr;
#ifdef EDGE_MCL_HAS_ROS
  return std::make_unique<BagWriter>(file, setup);
#else
  throw InputError(file + ": this build has no ROS, so it cannot write bags");
#endif
}

}  // namespace edge_mcl
