/// Makes a table like the paper's Table 1: time of the likelihood for growing numbers of particles.
#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <vector>

#include "edge_mcl/core/likelihood/likelihood_backend.h"

namespace edge_mcl {

/// Times the backends for every number of particles.
/// @param gpu null without a device.
/// @param frame image with its score table.
/// @param picture the picture from which this table was made. It is used for the times that include
/// a new image.
/// @param plain_ms_per_particle time of the plain flow, ms; it is proportional to the number of
/// particles.
/// @param sizes numbers of particles.
/// @param draw makes a given number of poses.
/// @param print true: each line is printed as soon as it is measured.
/// @return the lines as JSON; times in ms
nlohmann::json timeTable(const LikelihoodBackend& cpu, const LikelihoodBackend* gpu,
                         const LikelihoodFrame& frame, const Picture& picture,
                         double plain_ms_per_particle, const std::vector<size_t>& sizes,
                         const std::function<std::vector<Pose>(size_t)>& draw, bool print);

}  // namespace edge_mcl
