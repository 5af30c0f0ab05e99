/// Defines the interface between the device backend and a device. This header needs no CUDA.
#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>

#include "edge_mcl/gpu/math/particle_score.h"
#include "edge_mcl/gpu/math/table_recipe.h"

namespace edge_mcl::gpu {

/// A call to the device failed. The text names the call. The engine must not be used afterwards.
class DeviceError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Returns how many warps share one particle. Few particles get several warps each, so that the
/// device is busy.
inline int warpsFor(size_t particles) { return particles < 8192 ? kParts : 1; }

/// Holds the visibility cells and the score tables of images, and scores particles. Only one thread
/// at a time may use it. Every method may throw DeviceError.
class ScoringEngine {
 public:
  static constexpr int kImages = 4;  ///< number of tables that are kept

  virtual ~ScoringEngine() = default;
  /// Name of the device, e.g. "NVIDIA H100, compute capability 9.0".
  virtual std::string deviceName() const = 0;

  /// Uploads a cell. @param cell the engine sets its first_chunk. @param chunks
  /// cell.chunk_count elements. @param samples kLanes for every chunk. @return number of the cell
  /// for Particle::cell.
  virtual uint32_t addCell(Cell cell, const Chunk* chunks, const Sample* samples) = 0;
  /// Drops all cells.
  virtual void clearCells() = 0;

  /// Starts the upload of a table that the host made. The upload may overlap with scoring that
  /// still runs. The arguments may be freed after the call. @param image number of the table, 0 to
  /// kImages - 1; the table is replaced. @param pairs `count` elements, see ScoreTable::pairs.
  virtual void setTable(int image, const Camera& camera, const Table& table, const uint16_t* pairs,
                        size_t count) = 0;
  /// Starts the upload of a picture and the computation of its table on the device. Both may
  /// overlap with scoring that still runs. The recipe must live until the next call of
  /// setPicture(); the other arguments may be freed after the call. @param image as for setTable().
  virtual void setPicture(int image, const Camera& camera, const Table& table,
                          const TableRecipe& recipe, const PictureData& picture) = 0;

  /// Returns memory for `count` particles, which the caller fills. It is valid until the next call.
  virtual Particle* particles(size_t count) = 0;
  /// Starts scoring the `count` particles from number `first` on. They must be filled, and their
  /// cells must be on the device. @param image number of the table.
  virtual void submit(int image, const Rule& rule, const Combination& combination, size_t first,
                      size_t count) = 0;
  /// Blocks until all submitted particles are scored. @return one result for every particle of
  /// particles().
  virtual const Result* wait() = 0;
};

}  // namespace edge_mcl::gpu
