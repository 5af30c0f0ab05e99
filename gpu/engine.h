/// The measurement model on an NVIDIA GPU. This header needs no CUDA.
#pragma once

#include <cstddef>
#include <memory>
#include <stdexcept>
#include <string>

#include "particle_score.h"

namespace edge_mcl::gpu {

/// A CUDA call failed; the text names the call. The engine is not usable any more.
class DeviceError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Holds model, visibility cells and image tables on one device. Buffers only grow: after the first
/// frames nothing is allocated. Not for use from several threads at once.
class Engine {
 public:
  /// Why no device can be used; empty when one answers.
  static std::string whyUnavailable();

  /// @throws DeviceError
  Engine();
  ~Engine();
  Engine(const Engine&) = delete;
  Engine& operator=(const Engine&) = delete;

  /// E.g. "NVIDIA H100, compute capability 9.0".
  std::string deviceName() const;
  /// Device memory held by this engine, bytes.
  size_t deviceBytes() const;

  /// Positions of the model's samples along their segments; drops all cells.
  void setModel(const float* along, size_t count);
  /// Uploads a cell once. @param cell origin; its counts and positions are filled in.
  /// @param group_ends for each line, the number of segments up to its end.
  /// @return number of the cell, for Particle::cell.
  uint32_t addCell(Cell cell, const Segment* segments, size_t segment_count,
                   const uint32_t* group_ends, size_t group_count);
  size_t cellCount() const;
  void clearCells();

  /// Starts the upload of an image's table, which overlaps with a score() that still runs; the
  /// next score() uses it. @param pairs `count` elements, see ScoreTable::pairs; may be freed after
  /// the call.
  void setImage(const Camera& camera, const Table& table, const uint16_t* pairs, size_t count);

  /// Blocks until the results are there.
  void score(const Rule& rule, const Combination& combination, const Particle* particles,
             size_t count, Result* results);
  /// Milliseconds of the last score() on the device: kernel alone.
  float kernelMilliseconds() const;

  /// Teams of sixteen lanes that share one particle, for a number of particles.
  static int teamsFor(size_t particles);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace edge_mcl::gpu
