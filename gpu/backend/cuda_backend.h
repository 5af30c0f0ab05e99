/// The device backend on an NVIDIA GPU.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "edge_mcl/core/likelihood/likelihood_backend.h"

namespace edge_mcl {

/// Why there is no CUDA backend; empty when a device answers.
std::string whyNoCuda();

/// @param warn see DeviceBackend. @throws Error without a device.
std::unique_ptr<LikelihoodBackend> makeCudaBackend(std::shared_ptr<const Visibility> visibility,
                                                   std::function<void(const std::string&)> warn);

}  // namespace edge_mcl
