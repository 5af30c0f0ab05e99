/// Implements the engine's interface on the host with the same kernel bodies, for tests without a
/// device.
#pragma once

#include <array>

#include "edge_mcl/gpu/engine/scoring_engine.h"
#include "edge_mcl/gpu/workload/workload.h"

namespace edge_mcl::gpu {

/// A scoring engine on the host. Documentation of the methods: ScoringEngine.
class EmulatedEngine : public ScoringEngine {
 public:
  std::string deviceName() const override { return "emulation on the host"; }
  uint32_t addCell(Cell cell, const Chunk* chunks, const Sample* samples) override;
  void clearCells() override;
  void setTable(int image, const Camera& camera, const Table& table, const uint16_t* pairs,
                size_t count) override;
  void setPicture(int image, const Camera& camera, const Table& table, const TableRecipe& recipe,
                  const PictureData& picture) override;
  Particle* particles(size_t count) override;
  void submit(int image, const Rule& rule, const Combination& combination, size_t first,
              size_t count) override;
  const Result* wait() override { return results_.data(); }

 private:
  struct Image {
    Camera camera;
    Table table;
    std::vector<Quad> quads;
  };
  std::array<Image, kImages> image_;
  Workload state_;  ///< cells, and the data of the present submit()
  std::vector<Particle> particles_;
  std::vector<Result> results_;
};

}  // namespace edge_mcl::gpu
