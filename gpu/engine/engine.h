/// Computes the measurement model on an NVIDIA GPU. This header needs no CUDA.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "edge_mcl/gpu/engine/scoring_engine.h"

namespace edge_mcl::gpu {

/// Theoretical limits of the device.
struct DeviceLimits {
  double operations_per_second = 0;    ///< single precision, a fused multiply-add counts as one
  double memory_bytes_per_second = 0;  ///< device memory
};

/// A scoring engine that holds all data on one device. Its buffers only grow, so that after the
/// first images no memory is allocated. Documentation of the methods: ScoringEngine.
class Engine : public ScoringEngine {
 public:
  /// Returns the reason why no device can be used; empty when a device answers.
  static std::string whyUnavailable();

  /// Uses the current device of CUDA. @throws DeviceError when there is none, or its compute
  /// capability is below 7.5.
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

  /// Reads a table back from the device; empty when there is none.
  std::vector<Quad> table(int image);
  DeviceLimits limits() const;
  /// Device memory that this engine holds, bytes.
  size_t deviceBytes() const;
  /// Free memory of the whole device, bytes.
  static size_t freeBytes();
  /// Time of the kernel of the last submit() on the device, ms.
  float kernelMilliseconds() const;
  /// Time of the last setPicture() on the device, with the upload, ms.
  float pictureMilliseconds() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace edge_mcl::gpu
