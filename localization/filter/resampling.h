/// Weights, effective sample size, tempering and systematic resampling.
#pragma once

#include <cstdint>
#include <vector>

namespace edge_mcl {

/// Weights that sum to one from logarithms with any common offset. All equal when every
/// logarithm is minus infinity.
std::vector<double> normalize(const std::vector<double>& log_weights);

/// 1 / sum w^2 of normalised weights (A. Kong, J. Liu, W. Wong, JASA 89, 1994).
double effectiveSampleSize(const std::vector<double>& weights);

/// Largest exponent t <= 1 for which weights exp(fixed + t * log_likelihood) keep
/// ESS >= floor_share * N, or the ESS of `fixed` alone where that is already lower.
double temperingExponent(const std::vector<double>& fixed,
                         const std::vector<double>& log_likelihood, double floor_share);

/// Indices of `count` survivors, in ascending order. @param offset one random number in [0, 1).
std::vector<uint32_t> systematicResample(const std::vector<double>& weights, int count,
                                         double offset);

}  // namespace edge_mcl
