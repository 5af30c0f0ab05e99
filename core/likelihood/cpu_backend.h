/// SIMD and multi-threaded likelihood on the CPU.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "edge_mcl/core/likelihood/likelihood_backend.h"

namespace edge_mcl {

/// Lanes of the vector unit hold particles, so that every particle sums its samples in the same
/// order whatever its neighbours and the number of threads: results are bit-reproducible on one
/// instruction set. The instruction set is chosen at run time.
class CpuBackend : public LikelihoodBackend {
 public:
  explicit CpuBackend(std::shared_ptr<const Visibility> visibility);

  std::vector<PoseScore> evaluate(const LikelihoodFrame& frame,
                                  const std::vector<Pose>& camera_poses) const override;
  std::string name() const override;

  /// Particle-samples projected by the last call of evaluate (after culling): for benchmarks.
  /// Not meaningful while several threads call evaluate.
  uint64_t lastEvaluatedSamples() const { return last_evaluated_samples_; }

 private:
  std::shared_ptr<const Visibility> visibility_;
  mutable std::atomic<uint64_t> last_evaluated_samples_{0};
};

/// Poses against one visible set, without cells: the kernel alone.
std::vector<PoseScore> evaluateWithVisibleSet(const LikelihoodFrame& frame, const VisibleSet& set,
                                              const std::vector<Pose>& camera_poses);

}  // namespace edge_mcl
