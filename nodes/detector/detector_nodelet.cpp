// edge_mcl/Detector: the detector as a nodelet, which receives images without a copy.
#include <nodelet/nodelet.h>
#include <pluginlib/class_list_macros.hpp>

#include <memory>

#include "edge_mcl/nodes/detector/detector_run.h"

namespace edge_mcl {

class DetectorNodelet : public nodelet::Nodelet {
 private:
  void onInit() override {
    try {
      node_ = startDetector(getMTNodeHandle(), getMTPrivateNodeHandle());
    } catch (const std::exception& e) {
      NODELET_FATAL("%s", e.what());
      throw;  // the nodelet manager reports that the nodelet could not be loaded
    }
  }
  std::shared_ptr<void> node_;
};

}  // namespace edge_mcl

PLUGINLIB_EXPORT_CLASS(edge_mcl::DetectorNodelet, nodelet::Nodelet)
