/// Which likelihood backend a map uses.
#pragma once

#include "edge_mcl/core/localization_map.h"

namespace edge_mcl {

/// Sets the backend that `likelihood.backend` asks for; `auto` takes CUDA when it is built in and a
/// device answers. A device that fails later is reported on standard error, once.
/// @throws ParameterError when CUDA is asked for and cannot be had.
void chooseBackend(LocalizationMap* map);

}  // namespace edge_mcl
