#include "edge_mcl/mrpt_plugins/rawlog_input.h"

#include <mrpt/io/CFileGZInputStream.h>
#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CActionRobotMovement2D.h>
#include <mrpt/obs/CActionRobotMovement3D.h>
#include <mrpt/obs/CObservationOdometry.h>
#include <mrpt/obs/CObservationRobotPose.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/poses/CPose3D.h>
#include <mrpt/serialization/CArchive.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <functional>

#include "edge_mcl/core/error.h"
#include "edge_mcl/mrpt_plugins/mrpt_conversions.h"
#include "edge_mcl/mrpt_plugins/observation_input.h"

namespace edge_mcl {

using mrpt::obs::CObservation;

struct RawlogInput::Impl {
  std::string name;
  bool masks = true, depths = false;
  mrpt::io::CFileGZInputStream stream;
  std::optional<PoseGaussian> initial;  // never
  Trajectory truth;
  size_t images = 0;
  std::optional<Pose> odometry;

  void open() {
    // MRPT's stream fails in ways of its own.
    std::error_code error;
    if (!std::filesystem::is_regular_file(name, error) ||
        std::filesystem::file_size(name, error) == 0 || !stream.open(name))
      throw InputError(name + ": missing, empty or not readable");
  }

  /// @return null at the end.
  mrpt::serialization::CSerializable::Ptr read() {
    if (stream.checkEOF()) return nullptr;
    try {
      return mrpt::serialization::archiveFrom(stream).ReadObject();
    } catch (const std::exception&) {
      if (stream.checkEOF()) return nullptr;
      throw InputError(name + ": broken, or not a rawlog");
    }
  }

  void move(const mrpt::obs::CActionCollection& actions) {
    mrpt::poses::CPose3D step;
    if (const auto in_space = actions.getActionByClass<mrpt::obs::CActionRobotMovement3D>())
      step = in_space->poseChange.mean;
    else if (const auto in_plane = actions.getBestMovementEstimation())
      step = mrpt::poses::CPose3D(in_plane->poseChange->getMeanVal());
    else
      return;
    odometry = normalized(odometry.value_or(Pose::Identity()) * toPose(step));
  }

  static double timeOf(const CObservation& obs) { return mrpt::Clock::toDouble(obs.timestamp); }

  /// Observations of one object of the file, in their order.
  static void each(const mrpt::serialization::CSerializable::Ptr& object,
                   const std::function<void(const CObservation&)>& visit) {
    if (const auto frame = std::dynamic_pointer_cast<mrpt::obs::CSensoryFrame>(object)) {
      for (const CObservation::Ptr& obs : *frame) visit(*obs);
    } else if (const auto obs = std::dynamic_pointer_cast<CObservation>(object)) {
      visit(*obs);
    }
  }

  void survey() {
    open();
    while (const auto object = read())
      each(object, [&](const CObservation& obs) {
        images += hasImage(obs) ? 1 : 0;
        const auto* pose = dynamic_cast<const mrpt::obs::CObservationRobotPose*>(&obs);
        if (pose == nullptr) return;
        char time[32];
        std::snprintf(time, sizeof time, "%.6f", timeOf(obs));
        truth.push_back({timeOf(obs), time, toPose(pose->pose.mean)});
      });
    if (images == 0) throw InputError(name + ": no images in it");
    std::stable_sort(truth.begin(), truth.end(),
                     [](const StampedPose& a, const StampedPose& b) { return a.time < b.time; });
    stream.close();
    open();
  }

  void add(const CObservation& obs, LiveInput* input) const {
    if (const auto image = imageOf(obs)) {
      LiveInput::View view;
      view.camera = image->camera;
      view.T_base_camera = image->T_base_camera;
      view.origin = name + ": " + originOf(obs);
      // Copied: the observation is gone after this moment.
      view.image = image->pixels.clone();
      if (masks) view.mask = image->mask.clone();
      input->time = timeOf(obs);
      input->views.push_back(std::move(view));
    }
    if (!depths) return;
    if (const auto depth = depthOf(obs)) {
      LiveInput::Depth d{depth->image, depth->T_base_camera, 0};
      d.image.depth = depth->image.depth.clone();
      if (d.image.mask) d.image.mask->pixels = d.image.mask->pixels.clone();
      input->depths.push_back(std::move(d));
    }
  }
};

RawlogInput::RawlogInput(const std::string& file, bool masks, bool depths)
    : impl_(std::make_unique<Impl>()) {
  impl_->name = file;
  impl_->masks = masks;
  impl_->depths = depths;
  impl_->survey();
}

RawlogInput::~RawlogInput() = default;

size_t RawlogInput::imageCount() const { return impl_->images; }
const std::optional<PoseGaussian>& RawlogInput::initialPose() const { return impl_->initial; }
const Trajectory& RawlogInput::truth() const { return impl_->truth; }

bool RawlogInput::next(LiveInput* input, std::string* problem) {
  Impl& m = *impl_;
  *input = {};
  problem->clear();
  while (const auto object = m.read()) {
    if (const auto actions = std::dynamic_pointer_cast<mrpt::obs::CActionCollection>(object))
      m.move(*actions);
    bool seen = false;
    Impl::each(object, [&](const CObservation& obs) {
      if (const auto* odometry = dynamic_cast<const mrpt::obs::CObservationOdometry*>(&obs))
        m.odometry = toPose(mrpt::poses::CPose3D(odometry->odometry));
      try {
        seen |= hasImage(obs);
        m.add(obs, input);
      } catch (const InputError& e) {
        input->time = Impl::timeOf(obs);
        *problem = e.what();
      }
    });
    if (!seen) continue;
    input->odometry = m.odometry;
    return true;
  }
  return false;
}

}  // namespace edge_mcl
