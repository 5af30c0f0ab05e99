/// Writes and reads particles as a text file.
#pragma once

#include <string>
#include <vector>

#include "edge_mcl/core/base/se3.h"

namespace edge_mcl {

/// Particles with their weights.
struct ParticleSet {
  std::vector<Pose> poses;  ///< T_map_base
  std::vector<double> log_weights;
};

/// Writes one line "log_weight tx ty tz qx qy qz qw" per particle. The file appears only when it is
/// complete. @throws InputError when it cannot be written
void writeParticles(const std::string& file, const ParticleSet& particles);
/// Reads such a file. @throws InputError that names the line with the fault
ParticleSet readParticles(const std::string& file);

}  // namespace edge_mcl
