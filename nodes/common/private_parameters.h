/// A plain struct of parameters from a node's private namespace.
#pragma once

#include <string>
#include <vector>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/base/parameter_text.h"
#include "edge_mcl/nodes/localizer/node_parameters.h"

namespace edge_mcl {

/// Reads what is set into a struct with `visit(v)`, which calls v(name, field), and
/// `faults()`, which returns what is wrong with the values, one text each.
/// @throws ParameterError listing every unknown name with the nearest known one, every value of the
/// wrong type and every fault.
template <class Struct>
Struct readParameterStruct(const ros::NodeHandle& private_nh) {
  Struct params;
  std::vector<std::string> faults;
  for (const auto& [name, value] : readPrivateParameters(private_nh)) {
    if (isForeignParameter(name)) continue;
    bool known = false;
    std::vector<std::string> names;
    params.visit([&, &wanted = name, &text = value](const char* field_name, auto& field) {
      names.emplace_back(field_name);
      if (wanted != field_name) return;
      known = true;
      if (!parameter_text::fromText(text, &field))
        faults.emplace_back("parameter '~")
            .append(wanted)
            .append("': '")
            .append(text)
            .append("' is not ")
            .append(parameter_text::typeName(field));
    });
    if (!known)
      faults.push_back("unknown parameter '~" + name + "' (nearest: '~" + nearestName(name, names) +
                       "')");
  }
  for (std::string& fault : params.faults()) faults.push_back(std::move(fault));
  if (faults.empty()) return params;
  std::string all = faults.front();
  for (size_t i = 1; i < faults.size(); ++i) all += "; " + faults[i];
  throw ParameterError(all);
}

}  // namespace edge_mcl
