/// The measurement model on an NVIDIA GPU. This header needs no CUDA.
#pragma once

#include <cstddef>
#include <memory>
#include <string>

#include "scoring_engine.h"

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
  void setModel(const float* along, size_t count) override;
  uint32_t addCell(Cell cell, const Segment* segments, size_t segment_count,
                   const uint32_t* group_ends, size_t group_count) override;
  void clearCells() override;
  void setImage(const Camera& camera, const Table& table, const uint16_t* pairs,
                size_t count) override;
  void score(const Rule& rule, const Combination& combination, const Particle* particles,
             size_t count, Result* results) override;

  DeviceLimits limits() const;
  /// Device memory held by this engine, bytes.
  size_t deviceBytes() const;
  size_t cellCount() const;
  /// Milliseconds of the last score() on the device: kernel alone.
  float kernelMilliseconds() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace edge_mcl::gpu
