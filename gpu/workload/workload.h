/// One image, one model and many poses in a file: everything that a machine with a GPU and nothing
/// else needs to check and time the backend.
#pragma once

#include <string>
#include <vector>

#include "edge_mcl/gpu/math/particle_score.h"
#include "edge_mcl/gpu/math/table_recipe.h"

namespace edge_mcl::gpu {

struct Workload {
  std::string name;
  Camera camera{};
  Table table{};
  Rule rule{};
  Combination combination{};
  std::vector<uint16_t> pairs;  ///< score table, see ScoreTable::pairs
  TableRecipe recipe;           ///< of the table; no bins: it cannot be made on a device
  std::vector<uint8_t> grey;    ///< what the table was made of, without gaps between rows
  std::vector<uint8_t> ignore;  ///< empty without a mask
  std::vector<Chunk> chunks;    ///< of all cells
  std::vector<Sample> samples;  ///< kLanes for every chunk
  std::vector<Cell> cells;
  std::vector<Particle> particles;
  std::vector<double> reference;  ///< log-likelihoods of the CPU backend, one per particle
  double plain_ms = 0;            ///< plainly written flow, one thread, all particles
  double cpu_ms = 0;              ///< CPU backend, all threads, all particles
};

/// Native byte order; the machine that reads must be like the one that wrote.
/// @throws std::runtime_error naming the file.
void writeWorkload(const Workload& workload, const std::string& file);
/// Checks every index in the file. @throws std::runtime_error naming the file and the fault.
Workload readWorkload(const std::string& file);

}  // namespace edge_mcl::gpu
