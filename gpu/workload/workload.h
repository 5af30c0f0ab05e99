/// Reads and writes workload files. A workload has one image, one model and many poses. With it, a
/// machine that has only a GPU and this program can check and time the backend.
#pragma once

#include <string>
#include <vector>

#include "edge_mcl/gpu/math/particle_score.h"
#include "edge_mcl/gpu/math/table_recipe.h"

namespace edge_mcl::gpu {

/// Content of a workload file.
struct Workload {
  std::string name;
  Camera camera{};
  Table table{};
  Rule rule{};
  Combination combination{};
  std::vector<uint16_t> pairs;  ///< score table, see ScoreTable::pairs
  TableRecipe recipe;           ///< of the table; with 0 bins a device cannot make the table
  std::vector<uint8_t> grey;    ///< image of the table, without gaps between rows
  std::vector<uint8_t> ignore;  ///< ignored pixels, as `grey`; empty without a mask
  std::vector<Chunk> chunks;    ///< chunks of all cells
  std::vector<Sample> samples;  ///< kLanes for every chunk
  std::vector<Cell> cells;
  std::vector<Particle> particles;
  std::vector<double> reference;  ///< log-likelihoods of the CPU backend, one per particle
  double plain_ms = 0;            ///< time of the plain flow for all particles, one thread
  double cpu_ms = 0;              ///< time of the CPU backend for all particles, all threads
};

/// Writes a workload in native byte order. The machine that reads it must have the same byte order
/// and memory layout. @throws std::runtime_error with the name of the file.
void writeWorkload(const Workload& workload, const std::string& file);
/// Reads a workload and checks every index in it. @throws std::runtime_error with the name of the
/// file and the fault.
Workload readWorkload(const std::string& file);

}  // namespace edge_mcl::gpu
