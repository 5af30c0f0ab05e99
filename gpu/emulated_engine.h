/// The engine's interface on the host, by the same kernel body: for tests where there is no device.
#pragma once

#include "scoring_engine.h"
#include "workload.h"

namespace edge_mcl::gpu {

class EmulatedEngine : public ScoringEngine {
 public:
  std::string deviceName() const override { return "emulation on the host"; }
  void setModel(const float* along, size_t count) override;
  uint32_t addCell(Cell cell, const Segment* segments, size_t segment_count,
                   const uint32_t* group_ends, size_t group_count) override;
  void clearCells() override;
  void setImage(const Camera& camera, const Table& table, const uint16_t* pairs,
                size_t count) override;
  void score(const Rule& rule, const Combination& combination, const Particle* particles,
             size_t count, Result* results) override;

 private:
  Workload state_;
};

}  // namespace edge_mcl::gpu
