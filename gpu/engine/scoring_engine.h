/// What the device backend asks of a device. This header needs no CUDA.
#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>

#include "edge_mcl/gpu/math/particle_score.h"
#include "edge_mcl/gpu/math/table_recipe.h"

namespace edge_mcl::gpu {

/// A call to the device failed; the text names the call. The engine is not usable any more.
class DeviceError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Warps that share one particle: few particles get more of them, so that the device is full.
inline int warpsFor(size_t particles) { return particles < 8192 ? kParts : 1; }

/// Holds model, visibility cells and images' tables, and scores particles. Not for use from several
/// threads at once. Every method may throw DeviceError.
class ScoringEngine {
 public:
  static constexpr int kImages = 4;  ///< tables that are kept

  virtual ~ScoringEngine() = default;
  /// E.g. "NVIDIA H100, compute capability 9.0".
  virtual std::string deviceName() const = 0;

  /// Uploads a cell once. @param cell first_chunk is filled in.
  /// @param samples 32 for each of the cell's chunks. @return number, for Particle::cell.
  virtual uint32_t addCell(Cell cell, const Chunk* chunks, const Sample* samples) = 0;
  virtual void clearCells() = 0;

  /// Starts the upload of a table made on the host, or of a picture and the making of its table on
  /// the device. Either may overlap with scoring that still runs. What is passed may be freed after
  /// the call, but for the recipe, which has to live until the next call of setPicture.
  /// @param image 0 to kImages - 1; its table is replaced.
  /// @param pairs `count` elements, see ScoreTable::pairs.
  virtual void setTable(int image, const Camera& camera, const Table& table, const uint16_t* pairs,
                        size_t count) = 0;
  virtual void setPicture(int image, const Camera& camera, const Table& table,
                          const TableRecipe& recipe, const PictureData& picture) = 0;

  /// Memory for so many particles, for the caller to fill; valid until the next call.
  virtual Particle* particles(size_t count) = 0;
  /// Starts the scoring of those from `first` on, which are filled, each with a cell that is known.
  virtual void submit(int image, const Rule& rule, const Combination& combination, size_t first,
                      size_t count) = 0;
  /// Blocks until all that were submitted are scored. @return a result for each of particles().
  virtual const Result* wait() = 0;
};

}  // namespace edge_mcl::gpu
