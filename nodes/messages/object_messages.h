/// Converts objects that are not in the model to messages, and back.
#pragma once

#include <edge_mcl/ForeignObject.h>

#include <string>

#include "edge_mcl/localization/objects/object_follower.h"

namespace edge_mcl {

/// @param class_name empty: not known
ForeignObject toMessage(const ObjectState& object, const std::string& class_name);
/// @throws InputError when the place or the size is not finite, or the size is negative.
ObjectState fromMessage(const ForeignObject& message);

}  // namespace edge_mcl
