/// Functions for every plain parameter struct: set by name, check, describe.
///
/// Such a struct lists its fields once, in `visit(v)`, which calls
/// v(name, field, unit, range, text) for each. It may also have `faults()`, which returns what is
/// wrong between its fields, one text each.
#pragma once

#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/base/parameter_range.h"
#include "edge_mcl/core/base/parameter_text.h"

namespace edge_mcl {

/// @return the member of `known` with the smallest edit distance from `name`, for error messages
std::string nearestName(const std::string& name, const std::vector<std::string>& known);

/// @throws ParameterError that lists the faults, if there are any.
void throwFaults(const std::vector<std::string>& faults);

/// @param prefix stands before both names
/// @return "unknown parameter 'nam' (nearest: 'name')"
std::string unknownParameter(const std::string& name, const std::vector<std::string>& known,
                             const std::string& prefix = "");

struct ParameterDescription {
  std::string name, unit, range, text, value;
};

/// One entry per parameter, in the order of the list.
template <class Struct>
std::vector<ParameterDescription> describeParameters(Struct params) {
  std::vector<ParameterDescription> list;
  params.visit([&](const std::string& name, auto& field, const char* unit, const Range& range,
                   const char* text) {
    list.push_back(
        {name, unit, parameter_text::rangeText(field, range), text, parameter_text::toText(field)});
  });
  return list;
}

template <class Struct>
std::vector<std::string> parameterNames(Struct params) {
  std::vector<std::string> names;
  params.visit([&](const std::string& name, auto&, const char*, const Range&, const char*) {
    names.push_back(name);
  });
  return names;
}

/// Sets a field from text.
/// @return nothing for an unknown name; else the fault, which is empty when the field was set
template <class Struct>
std::optional<std::string> trySetParameter(const std::string& name, const std::string& value,
                                           Struct* params) {
  std::optional<std::string> result;
  params->visit([&](const std::string& field_name, auto& field, const char*, const Range&,
                    const char*) {
    if (name != field_name) return;
    auto parsed = field;
    result.emplace();
    if (parameter_text::fromText(value, &parsed))
      field = parsed;
    else
      *result =
          "parameter '" + name + "': '" + value + "' is not " + parameter_text::typeName(parsed);
  });
  return result;
}

/// Sets a field from text. @throws ParameterError for an unknown name (with the nearest known one)
/// or a value of the wrong type. The range is checked by `parameterFaults`.
template <class Struct>
void setParameter(const std::string& name, const std::string& value, Struct* params) {
  const std::optional<std::string> fault = trySetParameter(name, value, params);
  if (!fault) throw ParameterError(unknownParameter(name, parameterNames(*params)));
  if (!fault->empty()) throw ParameterError(*fault);
}

namespace parameter_struct {

template <class Struct, class = void>
struct HasFaults : std::false_type {};
template <class Struct>
struct HasFaults<Struct, std::void_t<decltype(std::declval<const Struct&>().faults())>>
    : std::true_type {};

}  // namespace parameter_struct

/// Fields outside their range, then what `faults()` of the struct says; one text each.
template <class Struct>
std::vector<std::string> parameterFaults(Struct params) {
  std::vector<std::string> list;
  params.visit(
      [&](const std::string& name, auto& field, const char*, const Range& range, const char*) {
        if (!range.allows(field))
          list.push_back(name + " = " + parameter_text::toText(field) + " must be " + range.text());
      });
  if constexpr (parameter_struct::HasFaults<Struct>::value)
    for (std::string& fault : params.faults()) list.push_back(std::move(fault));
  return list;
}

}  // namespace edge_mcl
