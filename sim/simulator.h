/// Flies a scenario and produces images, ground truth and odometry, image by image.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "edge_mcl/core/recordings/recording.h"
#include "edge_mcl/sim/scenario.h"

namespace edge_mcl {

/// Renders the images of a scenario and simulates its odometry.
class Simulator {
 public:
  /// Loads all models and makes the random flight, if there is one. @throws InputError when a model
  /// cannot be loaded, or the path comes too close to the building or leads through it.
  explicit Simulator(Scenario scenario);

  size_t imageCount() const { return image_count_; }
  /// Moves the objects and takes the next image of the path. @return false for a dropped image:
  /// then only its time and poses are set. @throws Error after the last image.
  bool next(RecordedFrame* frame);

  /// Takes an image at a time (s), for flights without a path. The objects are where their paths
  /// put them at that time. Times must increase. @param cameraAt T_map_camera at any time of the
  /// exposure. @param with_images false: only time and poses are set. @return as next().
  bool take(double time, const std::function<Pose(double)>& cameraAt, bool with_images,
            RecordedFrame* frame);
  /// Takes an image at a time (s) from a camera at rest.
  bool take(double time, const Pose& T_map_camera, bool with_images, RecordedFrame* frame);

  /// Setup of the recording. Its initial pose is drawn around the ground truth with the standard
  /// deviations of the setup.
  RecordingSetup setup() const;
  /// Describes noise, faults and objects, one line each.
  std::vector<std::string> notes() const;

  /// Whether a body may move straight between two points (map, m): nothing is in the way, and the
  /// end point keeps the scenario's clearance to the building.
  bool isFree(const Eigen::Vector3d& from, const Eigen::Vector3d& to) const;

  const Scenario& scenario() const { return scenario_; }
  /// Time of an image of the path, s.
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
