/// Makes the device backend for an NVIDIA GPU.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "edge_mcl/core/likelihood/likelihood_backend.h"

namespace edge_mcl {

/// Returns the reason why no CUDA backend is available; empty when a device answers.
std::string whyNoCuda();

/// Makes the backend. @param warn see DeviceBackend. @throws Error when no device can be used.
std::unique_ptr<LikelihoodBackend> makeCudaBackend(std::shared_ptr<const Visibility> visibility,
                                                   std::function<void(const std::string&)> warn);

}  // namespace edge_mcl
