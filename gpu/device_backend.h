/// Likelihood on a device behind the common interface.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>

#include "edge_mcl/core/cpu_backend.h"
#include "edge_mcl/gpu/scoring_engine.h"

namespace edge_mcl {

/// Scores on the device; what the device fails to do is done again on the CPU, and from then on
/// everything. Safe to use from many threads, which take turns.
class DeviceBackend : public LikelihoodBackend {
 public:
  /// @param kind for name(), e.g. "cuda". @param warn called once, with one line, when the device
  /// fails. @throws gpu::DeviceError when the engine cannot take the model.
  DeviceBackend(std::string kind, std::unique_ptr<gpu::ScoringEngine> engine,
                std::shared_ptr<const Visibility> visibility,
                std::function<void(const std::string&)> warn);
  ~DeviceBackend() override;

  std::vector<PoseScore> evaluate(const LikelihoodFrame& frame,
                                  const std::vector<Pose>& camera_poses) const override;
  std::string name() const override;

 private:
  std::vector<PoseScore> evaluateOnDevice(const LikelihoodFrame& frame,
                                          const std::vector<Pose>& camera_poses) const;
  uint32_t cellNumber(const CellKey& key) const;

  std::string kind_;
  std::shared_ptr<const Visibility> visibility_;
  std::function<void(const std::string&)> warn_;
  CpuBackend fallback_;
  mutable std::mutex mutex_;
  mutable std::unique_ptr<gpu::ScoringEngine> engine_;  ///< null after a failure
  mutable std::map<CellKey, uint32_t> cells_;           ///< on the device
  /// Whose table is on the device; kept alive, so that no other can have its address.
  mutable std::shared_ptr<const ScoreTable> table_;
};

}  // namespace edge_mcl
