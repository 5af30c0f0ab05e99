/// Times whole updates of the localizer, stage by stage.
#pragma once

#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "edge_mcl/core/localization_map.h"
#include "edge_mcl/core/recordings/sequence.h"

namespace edge_mcl {

/// Times of all updates, ms, for every stage. The stages are in the order of the work.
class StageTable {
 public:
  /// Localizes the first `images` images of a sequence. The time for reading files is not counted.
  static StageTable measure(const std::shared_ptr<const LocalizationMap>& map,
                            const Sequence& sequence, size_t images);
  bool empty() const { return stages_.empty(); }
  /// @param q from 0 to 1.
  /// @return ms; 0 for a stage without times
  double percentile(const std::string& stage, double q) const;
  /// Percentiles 50, 95 and 99 of every stage, ms.
  nlohmann::json toJson() const;
  /// Prints these percentiles under a title. Prints nothing when the table is empty.
  void print(const std::string& title) const;

 private:
  std::vector<std::pair<std::string, std::vector<double>>> stages_;
};

}  // namespace edge_mcl
