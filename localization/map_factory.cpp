#include "edge_mcl/localization/backend_choice.h"

#include <cstdio>
#include <utility>

#ifdef EDGE_MCL_HAS_CUDA
#include "edge_mcl/gpu/backend/cuda_backend.h"
#endif

namespace edge_mcl {

namespace {

/// Not by std::cerr, which the tool has closed to the libraries.
void warn(const std::string& text) { std::fprintf(stderr, "edge_mcl: %s\n", text.c_str()); }

}  // namespace

std::unique_ptr<LikelihoodBackend> makeDeviceBackend(std::shared_ptr<const Visibility> visibility) {
#ifdef EDGE_MCL_HAS_CUDA
  if (const std::string why = whyNoCuda(); !why.empty()) throw NoDevice(why);
  return makeCudaBackend(std::move(visibility), warn);
#else
  (void)visibility;
  throw NoDevice("built without CUDA");
#endif
}

void chooseBackend(LocalizationMap* map, const DeviceFactory& make_device) {
  const BackendChoice choice = map->params().likelihood.backend;
  if (choice == BackendChoice::kCpu) return;
  try {
    // One may be there and yet be busy, full or too old.
    map->setBackend(make_device(map->sharedVisibility()));
  } catch (const Error& e) {
    if (choice == BackendChoice::kCuda)
      throw ParameterError(std::string("likelihood.backend cuda: ") + e.what());
    if (dynamic_cast<const NoDevice*>(&e) == nullptr) warn(std::string(e.what()) + "; CPU used");
  }
}

}  // namespace edge_mcl
