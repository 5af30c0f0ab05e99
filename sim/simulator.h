/// Flies a scenario: images, truth and sensor readings, moment by moment.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "edge_mcl/core/recordings/recording.h"
#include "edge_mcl/sim/scenario.h"

namespace edge_mcl {

class Simulator {
 public:
  /// Loads all models. @throws InputError; also when the path comes too close to the building or
  /// leads through it.
  explicit Simulator(Scenario scenario);

  size_t imageCount() const { return image_count_; }
  /// Moves the objects and takes the next image. @return false for one that is dropped: only its
  /// time and poses are set.
  bool next(RecordedFrame* frame);

  /// What a camera sees at a time, with the objects where they are then; for flights that no path
  /// describes. Times must increase. @param cameraAt T_map_camera during the exposure.
  /// @param with_images false: poses only. @return as next().
  bool take(double time, const std::function<Pose(double)>& cameraAt, bool with_images,
            RecordedFrame* frame);
  /// From a camera at rest.
  bool take(double time, const Pose& T_map_camera, bool with_images, RecordedFrame* frame);

  /// With an initial pose drawn around the truth with its standard deviations.
  RecordingSetup setup() const;
  /// What noise, faults and objects there are, one line each.
  std::vector<std::string> notes() const;

  /// Whether a body may move in a straight line without coming closer to the building than the
  /// scenario's clearance.
  bool isFree(const Eigen::Vector3d& from, const Eigen::Vector3d& to) const;

  const Scenario& scenario() const { return scenario_; }
  double timeOf(size_t image) const;

 private:
  void checkPath() const;
  RenderedImage renderAt(double time, const Pose& T_map_camera);
  Scenario scenario_;
  std::unique_ptr<Scene> scene_;
  std::unique_ptr<Renderer> renderer_;
  OdometrySimulator odometry_;
  RandomSource random_;
  size_t image_count_ = 0, next_ = 0, taken_ = 0;
};

}  // namespace edge_mcl
