/// Sets the options of MRPT's 2D and 3D particle filters.
#pragma once

#include <mrpt/bayes/CParticleFilter.h>
#include <mrpt/random/RandomGenerators.h>

#include "edge_mcl/core/base/parameters.h"

namespace edge_mcl {

/// Returns the options as MRPT ships them: standard proposal, systematic resampling when the
/// effective sample size is below half of the particles. It also seeds MRPT's random numbers, which
/// have one source per process. @param power exponent of the likelihood, MRPT's powFactor.
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
