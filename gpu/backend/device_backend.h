/// Computes the likelihood on a device, behind the common interface.
#pragma once

#include <array>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <utility>

#include "edge_mcl/core/likelihood/cpu_backend.h"
#include "edge_mcl/gpu/engine/scoring_engine.h"

namespace edge_mcl {

/// Scores particles on the device. When the device fails, this call and all later calls use the
/// CPU. Thread-safe; threads take turns.
class DeviceBackend : public LikelihoodBackend {
 public:
  /// @param kind first word of name(), e.g. "cuda". @param warn is called once, with one line of
  /// text, when the device fails; may be empty.
  DeviceBackend(std::string kind, std::unique_ptr<gpu::ScoringEngine> engine,
                std::shared_ptr<const Visibility> visibility,
                std::function<void(const std::string&)> warn);
  ~DeviceBackend() override;

  std::vector<PoseScore> evaluate(const LikelihoodFrame& frame,
                                  const std::vector<Pose>& camera_poses) const override;
  std::string name() const override;
  bool makesTables(const ImageParameters& params) const override;
  void prefetch(const LikelihoodFrame& frame) const override;

 private:
  /// A cell and the thinning of its samples.
  using CellName = std::pair<CellKey, uint32_t>;
  /// A table that the device holds.
  struct Held {
    std::shared_ptr<const void> owner;  ///< kept alive, so that no other table gets its address
    uint64_t used = 0;                  ///< value of calls_ at the last use
    gpu::Camera camera{};
  };
  struct Recipe {
    std::shared_ptr<const ScoreLevels> levels;
    gpu::TableRecipe recipe;
  };

  std::vector<PoseScore> evaluateOnDevice(const LikelihoodFrame& frame,
                                          const std::vector<Pose>& camera_poses) const;
  int imageOf(const LikelihoodFrame& frame) const;
  const gpu::TableRecipe& recipeFor(const Picture& picture) const;
  void fill(const std::vector<Pose>& poses, uint32_t thinning, size_t first, size_t last,
            gpu::Particle* particles) const;
  void addCells(std::vector<CellKey> keys, uint32_t thinning) const;
  void giveUp(const gpu::DeviceError& error) const;

  std::string kind_;
  std::shared_ptr<const Visibility> visibility_;
  std::function<void(const std::string&)> warn_;
  CpuBackend fallback_;
  mutable std::mutex mutex_;
  mutable std::unique_ptr<gpu::ScoringEngine> engine_;  ///< null after a failure
  mutable std::map<CellName, uint32_t> cells_;          ///< numbers of the cells on the device
  mutable size_t cell_bytes_ = 0;
  mutable std::array<Held, gpu::ScoringEngine::kImages> held_;
  mutable uint64_t calls_ = 0;
  mutable std::list<Recipe> recipes_;  ///< for images of different sizes; the last used is last
};

}  // namespace edge_mcl
