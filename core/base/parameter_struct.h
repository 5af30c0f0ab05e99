/// What plain parameter structs with `visit(v)`, which calls v(name, field), have in common.
#pragma once

#include <string>
#include <vector>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/base/parameter_text.h"
#include "edge_mcl/core/base/parameters.h"

namespace edge_mcl {

/// @throws ParameterError listing the faults, if there are any.
inline void throwFaults(const std::vector<std::string>& faults) {
  std::string all;
  for (const std::string& fault : faults) all += (all.empty() ? "" : "; ") + fault;
  if (!all.empty()) throw ParameterError(all);
}

/// Sets a field from text. @throws ParameterError for an unknown name (naming the nearest) or a
/// wrong value.
template <class Struct>
void setParameter(const std::string& name, const std::string& value, Struct* params) {
  bool known = false;
  std::vector<std::string> names;
  params->visit([&](const char* field_name, auto& field) {
    names.emplace_back(field_name);
    if (name != field_name) return;
    known = true;
    auto parsed = field;
    if (!parameter_text::fromText(value, &parsed))
      throw ParameterError("parameter '" + name + "': '" + value + "' is not " +
                           parameter_text::typeName(parsed));
    field = parsed;
  });
  if (!known)
    throw ParameterError("unknown parameter '" + name + "' (nearest: '" + nearestName(name, names) +
                         "')");
}

}  // namespace edge_mcl
