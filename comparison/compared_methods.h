/// What is compared.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "edge_mcl/comparison/compared_filter.h"
#include "edge_mcl/core/recordings/sequence.h"

namespace edge_mcl {

enum class MethodKind { kOwn, kEdgesInMrptFilter, kPointMap, kFloorPlan, kDeadReckoning };

struct ComparedMethod {
  std::string name;   ///< short, for files
  std::string title;  ///< for people
  MethodKind kind = MethodKind::kOwn;
  bool needs_depth = false, needs_masks = false, uses_masks = true;
  /// Parameters that differ from the defaults.
  std::vector<std::pair<std::string, std::string>> settings;

  bool fits(const Sequence& sequence) const;
  /// Whether the number of particles matters.
  bool hasParticles() const { return kind != MethodKind::kDeadReckoning; }
  /// Whether it is one of MRPT's filters on one of MRPT's maps.
  bool isBuiltin() const { return kind == MethodKind::kPointMap || kind == MethodKind::kFloorPlan; }
};

const std::vector<ComparedMethod>& comparedMethods();
/// @throws ParameterError when there is none of that name; it lists them.
const ComparedMethod& comparedMethod(const std::string& name);

/// @throws InputError, ParameterError
std::unique_ptr<ComparedFilter> makeFilter(const ComparedMethod& method, const Sequence& sequence,
                                           int particles, uint64_t seed);

}  // namespace edge_mcl
