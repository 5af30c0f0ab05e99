#include "edge_mcl/core/base/parameter_struct.h"

#include <algorithm>

namespace edge_mcl {

std::string nearestName(const std::string& name, const std::vector<std::string>& known) {
  std::string best;
  size_t best_distance = 1000;
  for (const std::string& candidate : known) {
    std::vector<size_t> row(candidate.size() + 1);
    for (size_t j = 0; j < row.size(); ++j) row[j] = j;
    for (size_t i = 1; i <= name.size(); ++i) {
      size_t diagonal = row[0];
      row[0] = i;
      for (size_t j = 1; j <= candidate.size(); ++j) {
        const size_t above = row[j];
        row[j] = std::min(
            {above + 1, row[j - 1] + 1, diagonal + (name[i - 1] == candidate[j - 1] ? 0u : 1u)});
        diagonal = above;
      }
    }
    if (row.back() < best_distance) {
      best_distance = row.back();
      best = candidate;
    }
  }
  return best;
}

std::string unknownParameter(const std::string& name, const std::vector<std::string>& known,
                             const std::string& prefix) {
  return "unknown parameter '" + prefix + name + "' (nearest: '" + prefix +
         nearestName(name, known) + "')";
}

void throwFaults(const std::vector<std::string>& faults) {
  std::string all;
  for (const std::string& fault : faults) all += (all.empty() ? "" : "; ") + fault;
  if (!all.empty()) throw ParameterError(all);
}

}  // namespace edge_mcl
