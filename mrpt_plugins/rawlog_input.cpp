#include "edge_mcl/mrpt_plugins/rawlog_input.h"

#include <mrpt/img/CImage.h>
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
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <utility>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/mrpt_plugins/mrpt_conversions.h"
#include "edge_mcl/mrpt_plugins/observation_input.h"

namespace edge_mcl {

using mrpt::obs::CObservation;

namespace {

/// Folder of the image files of a rawlog. CRawlog::detectImagesDirectory() has the same purpose,
/// but its result in MRPT 2.5 lacks a slash.
std::string imagesFolderOf(const std::string& rawlog) {
  namespace fs = std::filesystem;
  const fs::path file(rawlog);
  std::error_code ignored;
  for (const char* ending : {"_Images", "_images", "_IMAGES"}) {
    const fs::path folder = file.parent_path() / (file.stem().string() + ending);
    if (fs::is_directory(folder, ignored)) return folder.string();
  }
  return (file.parent_path() / "Images").string();
}

}  // namespace

struct RawlogInput::Impl {
  std::string name, images_folder;
  bool masks = true, depths = false;
  mrpt::io::CFileGZInputStream stream;
  std::optional<PoseGaussian> initial;  // always empty
  Trajectory truth;
  std::optional<CameraModel> camera;
  size_t images = 0, ranges = 0;
  std::optional<Pose> odometry;
  bool trusts_actions = true;
  bool warned = false, cut_off = false;
  mrpt::serialization::CSerializable::Ptr pending;  // already read, belongs to the next moment

  void open() {
    // MRPT's stream reports these faults in ways of its own, so they are checked first.
    std::error_code error;
    if (!std::filesystem::is_regular_file(name, error) ||
        std::filesystem::file_size(name, error) == 0 || !stream.open(name))
      throw InputError(name + ": the file is missing, empty or not readable");
  }

  /// Reads the next object. @return null at the end of the file.
  mrpt::serialization::CSerializable::Ptr read() {
    if (stream.checkEOF()) return nullptr;
    const uint64_t begin = stream.getPosition();
    try {
      return mrpt::serialization::archiveFrom(stream).ReadObject();
    } catch (const std::exception&) {
      if (stream.checkEOF()) {
        cut_off = stream.getPosition() != begin;
        return nullptr;
      }
      throw InputError(name + ": the file is broken or not a rawlog");
    }
  }

  static std::optional<Pose> motionOf(const mrpt::obs::CActionCollection& actions) {
    if (const auto in_space = actions.getActionByClass<mrpt::obs::CActionRobotMovement3D>())
      return toPose(in_space->poseChange.mean);
    if (const auto in_plane = actions.getBestMovementEstimation())
      return toPose(mrpt::poses::CPose3D(in_plane->poseChange->getMeanVal()));
    return std::nullopt;
  }

  void move(const mrpt::obs::CActionCollection& actions) {
    const auto step = trusts_actions ? motionOf(actions) : std::nullopt;
    if (step) odometry = normalized(odometry.value_or(Pose::Identity()) * *step);
  }

  void look(const CObservation& obs) {
    const auto* message = dynamic_cast<const mrpt::obs::CObservationOdometry*>(&obs);
    if (message != nullptr) odometry = toPose(mrpt::poses::CPose3D(message->odometry));
  }

  static double timeOf(const CObservation& obs) { return mrpt::Clock::toDouble(obs.timestamp); }

  /// Visits the observations of one object of the file, in their order.
  static void each(const mrpt::serialization::CSerializable::Ptr& object,
                   const std::function<void(const CObservation&)>& visit) {
    if (const auto frame = std::dynamic_pointer_cast<mrpt::obs::CSensoryFrame>(object)) {
      for (const CObservation::Ptr& obs : *frame) visit(*obs);
    } else if (const auto obs = std::dynamic_pointer_cast<CObservation>(object)) {
      visit(*obs);
    }
  }

  void survey() {
    // rosbag2rawlog of MRPT 2.5 applies MRPT's 6-DoF motion model to odometry. This model turns
    // sideways motion into rotation. Most of its steps then rotate more than any flying robot does.
    constexpr double kWild = 0.5;  // rad; a step with a larger rotation is wild
    size_t steps = 0, wild_steps = 0;
    open();
    while (const auto object = read()) {
      if (const auto actions = std::dynamic_pointer_cast<mrpt::obs::CActionCollection>(object)) {
        const auto step = motionOf(*actions);
        steps += step ? 1 : 0;
        wild_steps += step && rotationAngle(Pose::Identity(), *step) > kWild ? 1 : 0;
      }
      each(object, [&](const CObservation& obs) {
        images += hasImage(obs) ? 1 : 0;
        ranges += hasDepth(obs) ? 1 : 0;
        const auto* pose = dynamic_cast<const mrpt::obs::CObservationRobotPose*>(&obs);
        if (pose == nullptr) return;
        char time[32];
        std::snprintf(time, sizeof time, "%.6f", timeOf(obs));
        truth.push_back({timeOf(obs), time, toPose(pose->pose.mean)});
      });
    }
    trusts_actions = 2 * wild_steps <= steps;
    if (images == 0 && !(depths && ranges > 0))
      throw InputError(name + (cut_off
                                   ? ": the file is cut off before its first image, or not a rawlog"
                                   : ": there are no images in the file"));
    std::stable_sort(truth.begin(), truth.end(),
                     [](const StampedPose& a, const StampedPose& b) { return a.time < b.time; });
    stream.close();
    open();
  }

  void add(const CObservation& obs, LiveInput* input) const {
    mrpt::img::CImage::setImagesPathBase(images_folder);  // holds for the whole process
    if (const auto image = imageOf(obs, camera ? &*camera : nullptr)) {
      LiveInput::CameraImage view;
      view.camera = image->camera;
      view.T_base_camera = image->T_base_camera;
      view.origin = name + ": " + originOf(obs);
      // The pixels are copied, because the observation does not live longer than this moment.
      view.image = image->pixels.clone();
      if (masks) view.mask = image->mask.clone();
      input->time = timeOf(obs);
      input->images.push_back(std::move(view));
    }
    if (!depths) return;
    if (const auto depth = depthOf(obs)) {
      if (images == 0) input->time = timeOf(obs);
      LiveInput::Depth d{depth->image, depth->T_base_camera, 0};
      d.image.depth = depth->image.depth.clone();
      if (d.image.mask) d.image.mask->pixels = d.image.mask->pixels.clone();
      input->depths.push_back(std::move(d));
    }
  }
};

RawlogInput::RawlogInput(const std::string& file, bool masks, bool depths,
                         const std::optional<CameraModel>& camera)
    : impl_(std::make_unique<Impl>()) {
  impl_->name = file;
  impl_->images_folder = imagesFolderOf(file);
  impl_->masks = masks;
  impl_->depths = depths;
  impl_->camera = camera;
  impl_->survey();
}

RawlogInput::~RawlogInput() = default;

size_t RawlogInput::imageCount() const { return impl_->images > 0 ? impl_->images : impl_->ranges; }
const std::optional<PoseGaussian>& RawlogInput::initialPose() const { return impl_->initial; }
const Trajectory& RawlogInput::truth() const { return impl_->truth; }
size_t RawlogInput::rangeCount() const { return impl_->ranges; }
std::string RawlogInput::damage() const {
  if (!impl_->cut_off) return {};
  return impl_->name + ": cut off after " + std::to_string(imageCount()) + " images";
}

bool RawlogInput::next(LiveInput* input, std::string* problem) {
  Impl& m = *impl_;
  *input = {};
  problem->clear();
  if (!m.trusts_actions && !std::exchange(m.warned, true))
    *problem =
        m.name + ": the odometry is not used, because most of its steps turn by more than 0.5 rad";
  // Whether this moment already has an image or a range image from a single observation.
  bool has_image = false, has_depth = false;
  double time = 0;
  const auto use = [&](const CObservation& obs) {
    try {
      m.add(obs, input);
    } catch (const InputError& e) {
      input->time = Impl::timeOf(obs);
      *problem = e.what();
    }
    input->odometry = m.odometry;
  };
  const auto isComplete = [&] { return m.images > 0 ? has_image : has_depth; };
  const auto joins = [&](const CObservation& obs) {
    if (!has_image && !has_depth) return true;
    return std::abs(Impl::timeOf(obs) - time) <= kDepthWindow && !(hasImage(obs) && has_image) &&
           !(hasDepth(obs) && has_depth);
  };
  const auto take = [&](const CObservation& obs) {
    has_image = has_image || hasImage(obs);
    has_depth = has_depth || hasDepth(obs);
    time = Impl::timeOf(obs);
    use(obs);
  };
  // The range image of an image may follow it. Without range images in the file, or without images,
  // the moment is complete at once.
  while (!(isComplete() && (m.ranges == 0 || m.images == 0 || has_depth))) {
    const auto object = m.pending ? std::exchange(m.pending, nullptr) : m.read();
    if (!object) return isComplete();
    if (const auto actions = std::dynamic_pointer_cast<mrpt::obs::CActionCollection>(object)) {
      m.move(*actions);
    } else if (const auto frame = std::dynamic_pointer_cast<mrpt::obs::CSensoryFrame>(object)) {
      bool seen = false;
      for (const CObservation::Ptr& obs : *frame)
        seen |= m.images > 0 ? hasImage(*obs) : hasDepth(*obs);
      for (const CObservation::Ptr& obs : *frame) m.look(*obs);
      if (!seen) continue;
      if (isComplete()) {
        m.pending = frame;
        return true;
      }
      *input = {};
      for (const CObservation::Ptr& obs : *frame) use(*obs);
      return true;
    } else if (const auto obs = std::dynamic_pointer_cast<CObservation>(object)) {
      m.look(*obs);
      if (!hasImage(*obs) && !hasDepth(*obs)) continue;
      if (joins(*obs)) {
        take(*obs);
      } else if (isComplete()) {
        m.pending = obs;
        return true;
      } else {
        // The range image read before has no image, so it is left out.
        *input = {};
        has_image = has_depth = false;
        take(*obs);
      }
    }
  }
  return true;
}

}  // namespace edge_mcl
