/// Particles in a text file.
#pragma once

#include <string>
#include <vector>

#include "edge_mcl/core/base/se3.h"

namespace edge_mcl {

struct ParticleSet {
  std::vector<Pose> poses;  ///< T_map_base
  std::vector<double> log_weights;
};

/// Lines "log_weight tx ty tz qx qy qz qw". The file appears only when it is complete.
/// @throws InputError
void writeParticles(const std::string& file, const ParticleSet& particles);
/// @throws InputError naming the line at fault.
ParticleSet readParticles(const std::string& file);

}  // namespace edge_mcl
