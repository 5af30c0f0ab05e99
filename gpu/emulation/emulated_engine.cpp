#include "edge_mcl/gpu/emulation/emulated_engine.h"

#include <algorithm>

#include "edge_mcl/gpu/emulation/host_emulation.h"
#include "edge_mcl/gpu/emulation/table_emulation.h"

namespace edge_mcl::gpu {

uint32_t EmulatedEngine::addCell(Cell cell, const Chunk* chunks, const Sample* samples) {
  cell.first_chunk = static_cast<uint32_t>(state_.chunks.size());
  state_.chunks.insert(state_.chunks.end(), chunks, chunks + cell.chunk_count);
  state_.samples.insert(state_.samples.end(), samples,
                        samples + static_cast<size_t>(cell.chunk_count) * kLanes);
  state_.cells.push_back(cell);
  return static_cast<uint32_t>(state_.cells.size() - 1);
}

void EmulatedEngine::clearCells() {
  state_.chunks.clear();
  state_.samples.clear();
  state_.cells.clear();
}

void EmulatedEngine::setTable(int image, const Camera& camera, const Table& table,
                              const uint16_t* pairs, size_t count) {
  if (count < quadsOf(table)) throw DeviceError("emulation: table too small");
  image_.at(image) = {camera, table, emulateTable(table, pairs)};
}

void EmulatedEngine::setPicture(int image, const Camera& camera, const Table& table,
                                const TableRecipe& recipe, const PictureData& picture) {
  image_.at(image) = {camera, table, emulateTable(recipe, picture)};
}

Particle* EmulatedEngine::particles(size_t count) {
  particles_.resize(count);
  results_.resize(count);
  return particles_.data();
}

void EmulatedEngine::submit(int image, const Rule& rule, const Combination& combination,
                            size_t first, size_t count) {
  const Image& i = image_.at(image);
  if (i.quads.empty()) throw DeviceError("emulation: no such table");
  state_.camera = i.camera;
  state_.table = i.table;
  state_.rule = rule;
  state_.combination = combination;
  state_.particles.assign(particles_.begin() + static_cast<long>(first),
                          particles_.begin() + static_cast<long>(first + count));
  for (const Particle& p : state_.particles)
    if (p.cell >= state_.cells.size()) throw DeviceError("emulation: particle in no known cell");
  const std::vector<Result> computed = emulate(state_, i.quads, warpsFor(particles_.size()));
  std::copy(computed.begin(), computed.end(), results_.begin() + static_cast<long>(first));
}

}  // namespace edge_mcl::gpu
