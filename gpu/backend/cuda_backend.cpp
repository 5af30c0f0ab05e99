#include "edge_mcl/gpu/backend/cuda_backend.h"

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/gpu/backend/device_backend.h"
#include "edge_mcl/gpu/engine/engine.h"

namespace edge_mcl {

std::string whyNoCuda() { return gpu::Engine::whyUnavailable(); }

std::unique_ptr<LikelihoodBackend> makeCudaBackend(std::shared_ptr<const Visibility> visibility,
                                                   std::function<void(const std::string&)> warn) {
  try {
    return std::make_unique<DeviceBackend>("cuda", std::make_unique<gpu::Engine>(),
                                           std::move(visibility), std::move(warn));
  } catch (const gpu::DeviceError& e) {
    throw Error(e.what());
  }
}

}  // namespace edge_mcl
