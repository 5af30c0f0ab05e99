/// Times of whole updates, stage by stage.
#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "edge_mcl/core/localization_map.h"
#include "edge_mcl/core/recordings/sequence.h"

namespace edge_mcl {

/// Milliseconds of every update, by stage, in the order of their work.
class StageTable {
 public:
  /// Tracks the first `images` of a sequence: image in, pose out, reading of files not counted.
  static StageTable measure(const LocalizationMap& map, const Sequence& sequence, size_t images);
  bool empty() const { return stages_.empty(); }
  double percentile(const std::string& stage, double q) const;
  nlohmann::json toJson() const;
  void print(const std::string& title) const;

 private:
  std::vector<std::pair<std::string, std::vector<double>>> stages_;
};

}  // namespace edge_mcl
