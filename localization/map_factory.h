/// Makes localization maps with the likelihood backend that their parameters ask for.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/localization_map.h"

namespace edge_mcl {

/// There is no device, or this build cannot use one.
class NoDevice : public Error {
 public:
  using Error::Error;
};

/// Makes the backend of a device. @throws NoDevice; Error when a device exists but cannot be used
using DeviceFactory =
    std::function<std::unique_ptr<LikelihoodBackend>(std::shared_ptr<const Visibility>)>;

/// The CUDA backend, where it is built in and a device answers. A device that fails later is
/// reported once on standard error. @throws as DeviceFactory
std::unique_ptr<LikelihoodBackend> makeDeviceBackend(std::shared_ptr<const Visibility> visibility);

/// Loads a model and gives the map the backend that `likelihood.backend` asks for. `auto` takes the
/// device where it can be used. A device that exists but cannot be used is reported on standard
/// error.
/// @throws InputError when the model cannot be read; ParameterError when a parameter is illegal, or
/// when CUDA is asked for and cannot be used
std::shared_ptr<LocalizationMap> makeMap(const std::string& model_file, const Parameters& params);

/// The second step of `makeMap`, for a map that exists already. @throws as makeMap
void chooseBackend(LocalizationMap* map, const DeviceFactory& make_device = makeDeviceBackend);

}  // namespace edge_mcl
