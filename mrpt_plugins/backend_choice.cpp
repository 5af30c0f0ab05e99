#include "edge_mcl/mrpt_plugins/backend_choice.h"

#include <cstdio>

#include "edge_mcl/core/error.h"

#ifdef EDGE_MCL_HAS_CUDA
#include "edge_mcl/gpu/cuda_backend.h"
#endif

namespace edge_mcl {

void chooseBackend(LocalizationMap* map) {
  const BackendChoice choice = map->params().likelihood.backend;
  if (choice == BackendChoice::kCpu) return;
#ifdef EDGE_MCL_HAS_CUDA
  const std::string why = whyNoCuda();
  if (why.empty())
    map->setBackend(makeCudaBackend(map->sharedVisibility(), [](const std::string& warning) {
      // Not by std::cerr, which the tool has closed to the libraries.
      std::fprintf(stderr, "edge_mcl: %s\n", warning.c_str());
    }));
#else
  const std::string why = "built without CUDA";
#endif
  if (choice == BackendChoice::kCuda && !why.empty())
    throw ParameterError("likelihood.backend cuda: " + why);
}

}  // namespace edge_mcl
