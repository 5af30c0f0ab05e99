#include "edge_mcl/core/base/parameters.h"

#include <algorithm>
#include <cctype>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/base/parameter_struct.h"
#include "edge_mcl/core/base/yaml_file.h"

namespace edge_mcl {

namespace {

/// Text of a value in YAML. An empty text and one with a special character need quotes.
std::string yamlScalar(const std::string& value) {
  const bool is_plain =
      !value.empty() && std::all_of(value.begin(), value.end(), [](unsigned char c) {
        return std::isalnum(c) || c == '.' || c == '-' || c == '+' || c == '_';
      });
  if (is_plain) return value;
  std::string quoted = "'";
  for (const char c : value) quoted += c == '\'' ? "''" : std::string(1, c);
  return quoted + "'";
}

}  // namespace

void Parameters::set(const std::string& dotted_name, const std::string& value) {
  setParameter(dotted_name, value, this);
}

std::string Parameters::get(const std::string& dotted_name) const {
  for (const ParameterDescription& d : describeParameters(*this))
    if (d.name == dotted_name) return d.value;
  throw ParameterError(unknownParameter(dotted_name, parameterNames(*this)));
}

std::string Parameters::toYaml() const {
  std::string text, group;
  for (const ParameterDescription& d : describeParameters(*this)) {
    const auto dot = d.name.find('.');
    if (d.name.substr(0, dot) != group) {
      group = d.name.substr(0, dot);
      text += group + ":\n";
    }
    text += "  " + d.name.substr(dot + 1) + ": " + yamlScalar(d.value) + "   # " +
            (d.unit.empty() ? "" : "[" + d.unit + "] ") + d.text + " (" + d.range + ")\n";
  }
  return text;
}

void Parameters::loadYaml(const std::string& file) {
  const YAML::Node root = loadYamlFile(file);
  if (root.IsNull()) return;
  if (!root.IsMap()) throw ParameterError(file + ": groups of parameters expected");
  std::string faults;
  const auto attempt = [&](const std::string& name, const YAML::Node& value) {
    try {
      if (!value.IsScalar()) throw ParameterError("parameter '" + name + "' needs one value");
      set(name, value.Scalar());
    } catch (const ParameterError& e) {
      faults += std::string(faults.empty() ? "" : "; ") + e.what();
    }
  };
  for (const auto& group : root) {
    const auto group_name = group.first.as<std::string>();
    if (group.second.IsMap())
      for (const auto& entry : group.second)
        attempt(group_name + "." + entry.first.as<std::string>(), entry.second);
    else
      attempt(group_name, group.second);
  }
  if (!faults.empty()) throw ParameterError(file + ": " + faults);
  validate();
}

std::vector<std::string> Parameters::faults() const {
  std::vector<std::string> list;
  const auto require = [&](bool good, const std::string& name, const std::string& rule) {
    if (!good) list.push_back(name + " = " + get(name) + " must be " + rule);
  };
  for (const std::string& fault : map.faults()) list.push_back("map." + fault);
  require(depth.max_range > depth.min_range, "depth.max_range", "more than depth.min_range");
  // The kernel computes in single precision with residuals in units of sigma.
  require(depth.sigma >= 1e-4 * depth.truncation, "depth.sigma",
          "at least a ten-thousandth of depth.truncation");
  require(refinement.final_search_length <= refinement.search_length,
          "refinement.final_search_length", "1 to refinement.search_length");
  // Tempering leaves ESS/N at the floor. With a threshold below it, particles would never be
  // resampled and no image would be used.
  const bool always_resamples = refinement.enabled && filter.refined_share > 0;
  require(always_resamples || !(filter.resample_threshold <= filter.ess_floor),
          "filter.resample_threshold", "above filter.ess_floor, without refinement");
  require(filter.recovery_alpha_fast >= filter.recovery_alpha_slow, "filter.recovery_alpha_fast",
          "from filter.recovery_alpha_slow to 1");
  require((filter.recovery_alpha_slow > 0) == (filter.recovery_alpha_fast > 0),
          "filter.recovery_alpha_slow", "zero when recovery_alpha_fast is, positive when it is");
  require(search.window >= std::max(2, search.min_keyframes), "search.window",
          "2 or search.min_keyframes to 1000");
  return list;
}

void Parameters::validate() const {
  std::vector<std::string> faults = parameterFaults(*this);
  if (!faults.empty()) faults.front().insert(0, "parameters: ");
  throwFaults(faults);
}

}  // namespace edge_mcl
