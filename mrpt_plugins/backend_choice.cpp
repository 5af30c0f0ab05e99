#include "edge_mcl/mrpt_plugins/backend_choice.h"

#include <cstdio>
#include <utility>

#include "edge_mcl/core/error.h"

#ifdef EDGE_MCL_HAS_CUDA
#include "edge_mcl/gpu/cuda_backend.h"
#endif

namespace edge_mcl {

std::unique_ptr<LikelihoodBackend> makeDeviceBackend(std::shared_ptr<const Visibility> visibility) {
#ifdef EDGE_MCL_HAS_CUDA
  if (const std::string why = whyNoCuda(); !why.empty()) throw Error(why);
  return makeCudaBackend(std::move(visibility), [](const std::string& warning) {
    // Not by std::cerr, which the tool has closed to the libraries.
    std::fprintf(stderr, "edge_mcl: %s\n", warning.c_str());
  });
#else
  (void)visibility;
  throw Error("built without CUDA");
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
  }
}

}  // namespace edge_mcl
