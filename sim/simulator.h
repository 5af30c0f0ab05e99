/// Flies a scenario: images, truth and sensor readings, moment by moment.
#pragma once

#include "edge_mcl/sim/scenario.h"
#include "edge_mcl/sim/sequence_writer.h"

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

  /// Initial pose drawn around the truth with its standard deviations; notes on the noise.
  SequenceDescription describe() const;

  const Scenario& scenario() const { return scenario_; }
  double timeOf(size_t image) const;

 private:
  void checkPath() const;
  RenderedImage renderAt(double time);
  Scenario scenario_;
  std::unique_ptr<Scene> scene_;
  std::unique_ptr<Renderer> renderer_;
  OdometrySimulator odometry_;
  RandomSource random_;
  size_t image_count_ = 0, next_ = 0;
};

}  // namespace edge_mcl
