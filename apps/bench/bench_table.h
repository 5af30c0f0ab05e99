/// The paper's Table 1 for today's hardware.
#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <vector>

#include "edge_mcl/core/likelihood/likelihood_backend.h"

namespace edge_mcl {

/// Times backends for growing numbers of particles and prints one line each as it is done.
/// @param plain_ms_per_particle the plainly written flow, whose time is proportional to the number.
/// @param picture of which the frame's table was made, for the times from the image on.
/// @param draw makes that many poses. @param gpu null without a device.
/// @return the lines as JSON.
nlohmann::json timeTable(const LikelihoodBackend& cpu, const LikelihoodBackend* gpu,
                         const LikelihoodFrame& frame, const Picture& picture,
                         double plain_ms_per_particle, const std::vector<size_t>& sizes,
                         const std::function<std::vector<Pose>(size_t)>& draw, bool print);

}  // namespace edge_mcl
