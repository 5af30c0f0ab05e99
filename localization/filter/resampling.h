/// Weights of particles: normalization, effective sample size, tempering, systematic resampling.
#pragma once

#include <cstdint>
#include <vector>

namespace edge_mcl {

/// Weights from log weights, in the same order, with the sum 1. All weights are equal when the
/// highest log weight is not finite, for example when every log weight is minus infinity.
/// @param log_weights at least one. They may have any common offset.
std::vector<double> normalize(const std::vector<double>& log_weights);

/// Effective sample size (ESS) of weights with the sum 1: 1 / sum w^2 (A. Kong, J. Liu, W. Wong,
/// JASA 89, 1994).
double effectiveSampleSize(const std::vector<double>& weights);

/// The largest exponent t <= 1 for which the weights exp(fixed + t * log_likelihood) keep
/// ESS >= floor_share * N. Where `fixed` alone has a lower ESS, that ESS is the bound instead. The
/// result is at most 1e-4 below the exact value.
/// @param fixed log weights without the likelihood. @param log_likelihood one for each of them.
double temperingExponent(const std::vector<double>& fixed,
                         const std::vector<double>& log_likelihood, double floor_share);

/// Systematic resampling: indices of `count` survivors, in ascending order.
/// @param weights with the sum 1. @param offset one random number in [0, 1).
std::vector<uint32_t> systematicResample(const std::vector<double>& weights, int count,
                                         double offset);

}  // namespace edge_mcl
