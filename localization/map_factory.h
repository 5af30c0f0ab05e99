/// Which likelihood backend a map uses.
#pragma once

#include <functional>
#include <memory>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/localization_map.h"

namespace edge_mcl {

/// There is no device, or nothing in this build that could use it.
class NoDevice : public Error {
 public:
  using Error::Error;
};

/// Makes the backend of a device. @throws NoDevice; Error when there is one that cannot be had.
using DeviceFactory =
    std::function<std::unique_ptr<LikelihoodBackend>(std::shared_ptr<const Visibility>)>;
/// CUDA, where it is built in and a device answers. A device that fails later is reported on
/// standard error, once.
std::unique_ptr<LikelihoodBackend> makeDeviceBackend(std::shared_ptr<const Visibility> visibility);

/// Sets the backend that `likelihood.backend` asks for; `auto` takes the device when it can be had,
/// and says on standard error when there is one that cannot.
/// @throws ParameterError when CUDA is asked for and cannot be had.
void chooseBackend(LocalizationMap* map, const DeviceFactory& make_device = makeDeviceBackend);

}  // namespace edge_mcl
