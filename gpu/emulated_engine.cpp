#include "emulated_engine.h"

#include <algorithm>

#include "host_emulation.h"

namespace edge_mcl::gpu {

void EmulatedEngine::setModel(const float* along, size_t count) {
  state_.along.assign(along, along + count);
  clearCells();
}

uint32_t EmulatedEngine::addCell(Cell cell, const Segment* segments, size_t segment_count,
                                 const uint32_t* group_ends, size_t group_count) {
  cell.first_segment = static_cast<uint32_t>(state_.segments.size());
  cell.first_group = static_cast<uint32_t>(state_.group_ends.size());
  cell.group_count = static_cast<uint32_t>(group_count);
  state_.segments.insert(state_.segments.end(), segments, segments + segment_count);
  state_.group_ends.insert(state_.group_ends.end(), group_ends, group_ends + group_count);
  state_.cells.push_back(cell);
  return static_cast<uint32_t>(state_.cells.size() - 1);
}

void EmulatedEngine::clearCells() {
  state_.segments.clear();
  state_.group_ends.clear();
  state_.cells.clear();
}

void EmulatedEngine::setImage(const Camera& camera, const Table& table, const uint16_t* pairs,
                              size_t count) {
  state_.camera = camera;
  state_.table = table;
  state_.pairs.assign(pairs, pairs + count);
}

void EmulatedEngine::score(const Rule& rule, const Combination& combination,
                           const Particle* particles, size_t count, Result* results) {
  if (state_.pairs.empty()) throw DeviceError("emulation: score before setImage");
  for (size_t i = 0; i < count; ++i)
    if (particles[i].cell >= state_.cells.size())
      throw DeviceError("emulation: particle in no known cell");
  state_.rule = rule;
  state_.combination = combination;
  state_.particles.assign(particles, particles + count);
  const std::vector<Result> computed = emulate(state_, teamsFor(count));
  std::copy(computed.begin(), computed.end(), results);
}

}  // namespace edge_mcl::gpu
