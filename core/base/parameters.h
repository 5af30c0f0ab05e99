/// All parameters of the method.
///
/// The same names are used in YAML (`group: {name: value}`), on the command line and in MRPT ini
/// files (`group.name`) and as ROS parameters (`group/name`).
#pragma once

#include <string>
#include <vector>

#include "edge_mcl/core/base/filter_parameters.h"
#include "edge_mcl/core/base/measurement_parameters.h"

namespace edge_mcl {

/// The groups of parameters. Functions of parameter_struct.h apply as well.
struct Parameters {
  MapParameters map;
  VisibilityParameters visibility;
  ImageParameters image;
  LikelihoodParameters likelihood;
  DepthParameters depth;
  RefinementParameters refinement;
  FilterParameters filter;
  TrackingParameters tracking;
  SearchParameters search;

  template <class Visitor>
  void visitGroups(Visitor&& v) {
    v("map", map);
    v("visibility", visibility);
    v("image", image);
    v("likelihood", likelihood);
    v("depth", depth);
    v("refinement", refinement);
    v("filter", filter);
    v("tracking", tracking);
    v("search", search);
  }

  /// Calls v(group.name, field, unit, range, text) for every parameter.
  template <class Visitor>
  void visit(Visitor&& v) {
    visitGroups([&](const char* group, auto& fields) {
      fields.visit(
          [&](const char* name, auto& field, const char* unit, const Range& range,
              const char* text) { v(std::string(group) + "." + name, field, unit, range, text); });
    });
  }

  /// Contradictions between parameters, one text each.
  std::vector<std::string> faults() const;
  /// Checks every range and `faults()`. @throws ParameterError that lists every illegal value
  void validate() const;

  /// Sets `group.name` from text. @throws ParameterError on an unknown name (with the nearest
  /// known one) or a value of the wrong type
  void set(const std::string& dotted_name, const std::string& value);
  /// @throws ParameterError on an unknown name
  std::string get(const std::string& dotted_name) const;

  /// Reads a YAML file over the present values, then validates. @throws ParameterError that lists
  /// all unknown keys and bad values; InputError when the file cannot be read
  void loadYaml(const std::string& file);
  /// Text that `loadYaml` reads, with unit and meaning as comments.
  std::string toYaml() const;
};

}  // namespace edge_mcl
