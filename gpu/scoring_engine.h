/// What the device backend asks of a device. This header needs no CUDA.
#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>

#include "particle_score.h"

namespace edge_mcl::gpu {

/// A call to the device failed; the text names the call. The engine is not usable any more.
class DeviceError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Teams of sixteen lanes that share one particle, for a number of particles: few particles get
/// more lanes each, so that the device is full.
inline int teamsFor(size_t particles) { return particles < 20000 ? 8 : 2; }

/// Holds model, visibility cells and an image's table, and scores particles. Not for use from
/// several threads at once. Every method may throw DeviceError.
class ScoringEngine {
 public:
  virtual ~ScoringEngine() = default;
  /// E.g. "NVIDIA H100, compute capability 9.0".
  virtual std::string deviceName() const = 0;

  /// Positions of the model's samples along their segments; drops all cells.
  virtual void setModel(const float* along, size_t count) = 0;
  /// Uploads a cell once. @param cell origin; its counts and positions are filled in.
  /// @param group_ends for each line, the number of segments up to its end.
  /// @return number of the cell, for Particle::cell.
  virtual uint32_t addCell(Cell cell, const Segment* segments, size_t segment_count,
                           const uint32_t* group_ends, size_t group_count) = 0;
  virtual void clearCells() = 0;

  /// Starts the upload of an image's table, which may overlap with a score() that still runs; the
  /// next score() uses it. @param pairs `count` elements, see ScoreTable::pairs; may be freed after
  /// the call.
  virtual void setImage(const Camera& camera, const Table& table, const uint16_t* pairs,
                        size_t count) = 0;

  /// Blocks until the results are there.
  virtual void score(const Rule& rule, const Combination& combination, const Particle* particles,
                     size_t count, Result* results) = 0;
};

}  // namespace edge_mcl::gpu
