/// How MRPT's particle filters are run, whatever their dimension.
#pragma once

#include <mrpt/bayes/CParticleFilter.h>
#include <mrpt/random/RandomGenerators.h>

#include "edge_mcl/core/base/parameters.h"

namespace edge_mcl {

/// As MRPT ships it: standard proposal, systematic resampling below half of the effective sample
/// size. Seeds MRPT's random numbers, of which there is one source per process.
/// @param power of the likelihood, MRPT's powFactor.
inline mrpt::bayes::CParticleFilter::TParticleFilterOptions runnerOptions(
    const FilterParameters& params, double power) {
  mrpt::bayes::CParticleFilter::TParticleFilterOptions options;
  options.PF_algorithm = mrpt::bayes::CParticleFilter::pfStandardProposal;
  options.resamplingMethod = mrpt::bayes::CParticleFilter::prSystematic;
  options.sampleSize = static_cast<unsigned>(params.particles);
  options.adaptiveSampleSize = false;
  options.powFactor = power;
  mrpt::random::getRandomGenerator().randomize(static_cast<uint32_t>(params.seed));
  return options;
}

}  // namespace edge_mcl
