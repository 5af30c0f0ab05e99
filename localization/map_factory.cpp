#include "edge_mcl/localization/map_factory.h"

#include <cstdio>
#include <utility>

#ifdef EDGE_MCL_HAS_CUDA
#include "edge_mcl/gpu/backend/cuda_backend.h"
#endif

namespace edge_mcl {

namespace {

/// The tool closes std::cerr, so that libraries cannot write to it. Standard error stays open.
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
    // A device may exist and still be busy, full or too old.
    map->setBackend(make_device(map->sharedVisibility()));
  } catch (const Error& e) {
    if (choice == BackendChoice::kCuda)
      throw ParameterError(std::string("likelihood.backend cuda: ") + e.what());
    if (dynamic_cast<const NoDevice*>(&e) == nullptr) warn(std::string(e.what()) + "; CPU used");
  }
}

std::shared_ptr<LocalizationMap> makeMap(const std::string& model_file, const Parameters& params) {
  auto map = std::make_shared<LocalizationMap>(model_file, params);
  if (params.tracking.mask_by_depth && !map->visibility().scene())
    throw InputError(model_file + ": masks by depth need surfaces, but the model has no faces");
  chooseBackend(map.get());
  return map;
}

}  // namespace edge_mcl
