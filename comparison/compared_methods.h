/// Lists the methods of the comparison and makes their filters.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "edge_mcl/comparison/compared_filter.h"
#include "edge_mcl/core/recordings/sequence.h"

namespace edge_mcl {

/// Filter and map of a method: edge_mcl, edge_mcl's map in MRPT's 3D filter, MRPT's 3D filter on a
/// point map, MRPT's 2D filter on a grid, dead reckoning.
enum class MethodKind { kOwn, kEdgesInMrptFilter, kPointMap, kFloorPlan, kDeadReckoning };

/// One method of the comparison.
struct ComparedMethod {
  std::string name;   ///< short name for files
  std::string title;  ///< name in tables and plots
  MethodKind kind = MethodKind::kOwn;
  bool needs_depth = false, needs_masks = false, uses_masks = true;
  /// Names and values of parameters that differ from the defaults.
  std::vector<std::pair<std::string, std::string>> settings;

  /// Whether the sequence has the data that the method needs.
  bool fits(const Sequence& sequence) const;
  /// Whether the method has particles.
  bool hasParticles() const { return kind != MethodKind::kDeadReckoning; }
  /// Whether the method is one of MRPT's filters on one of MRPT's maps.
  bool isBuiltin() const { return kind == MethodKind::kPointMap || kind == MethodKind::kFloorPlan; }
};

/// All methods, in the order of the tables.
const std::vector<ComparedMethod>& comparedMethods();
/// Returns the method with a name. @throws ParameterError for an unknown name; it lists all names.
const ComparedMethod& comparedMethod(const std::string& name);

/// Makes the filter of a method for the model of a sequence. @throws InputError, ParameterError
std::unique_ptr<ComparedFilter> makeFilter(const ComparedMethod& method, const Sequence& sequence,
                                           int particles, uint64_t seed);

}  // namespace edge_mcl
