/// The measurement model on an NVIDIA GPU. This header needs no CUDA.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "edge_mcl/gpu/engine/scoring_engine.h"

namespace edge_mcl::gpu {

/// What the device could do at best.
struct DeviceLimits {
  double operations_per_second = 0;    ///< single precision, a fused multiply-add counts as one
  double memory_bytes_per_second = 0;  ///< device memory
};

/// Holds everything on one device. Buffers only grow: after the first frames nothing is allocated.
class Engine : public ScoringEngine {
 public:
  /// Why no device can be used; empty when one answers.
  static std::string whyUnavailable();

  /// @throws DeviceError
  Engine();
  ~Engine() override;
  Engine(const Engine&) = delete;
  Engine& operator=(const Engine&) = delete;

  std::string deviceName() const override;
  uint32_t addCell(Cell cell, const Chunk* chunks, const Sample* samples) override;
  void clearCells() override;
  void setTable(int image, const Camera& camera, const Table& table, const uint16_t* pairs,
                size_t count) override;
  void setPicture(int image, const Camera& camera, const Table& table, const TableRecipe& recipe,
                  const PictureData& picture) override;
  Particle* particles(size_t count) override;
  void submit(int image, const Rule& rule, const Combination& combination, size_t first,
              size_t count) override;
  const Result* wait() override;

  /// Reads a table back from the device.
  std::vector<Quad> table(int image);
  DeviceLimits limits() const;
  /// Device memory held by this engine, bytes.
  size_t deviceBytes() const;
  /// Memory of the whole device that nobody holds, bytes.
  static size_t freeBytes();
  /// Milliseconds on the device, of the last submit(): kernel alone.
  float kernelMilliseconds() const;
  /// Of the last setPicture(), upload included.
  float pictureMilliseconds() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace edge_mcl::gpu
