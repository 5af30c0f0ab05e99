/// SIMD and multi-threaded likelihood on the CPU.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "edge_mcl/core/likelihood/likelihood_backend.h"

namespace edge_mcl {

/// Scores poses on the CPU. The lanes of the vector unit hold particles. So every particle adds its
/// samples in the same order, for any neighbours and any number of threads. Results have the same
/// bits on one instruction set. The instruction set is chosen at run time.
class CpuBackend : public LikelihoodBackend {
 public:
  explicit CpuBackend(std::shared_ptr<const Visibility> visibility);

  std::vector<PoseScore> evaluate(const LikelihoodFrame& frame,
                                  const std::vector<Pose>& camera_poses) const override;
  std::string name() const override;

  /// Number of particle-samples that the last call of evaluate() projected, after culling. It is
  /// for benchmarks, and has no meaning while several threads call evaluate().
  uint64_t lastEvaluatedSamples() const { return last_evaluated_samples_; }

 private:
  std::shared_ptr<const Visibility> visibility_;
  mutable std::atomic<uint64_t> last_evaluated_samples_{0};
};

/// Scores poses with one visible set, without cells: the kernel alone.
std::vector<PoseScore> evaluateWithVisibleSet(const LikelihoodFrame& frame, const VisibleSet& set,
                                              const std::vector<Pose>& camera_poses);

}  // namespace edge_mcl
