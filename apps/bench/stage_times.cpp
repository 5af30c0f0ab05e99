#include "apps/bench/stage_times.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "edge_mcl/localization/recorded/recorded_localizer.h"
#include "edge_mcl/localization/recorded/sequence_input.h"

namespace edge_mcl {

StageTable StageTable::measure(const std::shared_ptr<const LocalizationMap>& map,
                               const Sequence& sequence, size_t images) {
  StageTable table;
  if (images == 0) return table;
  table.stages_ = {{"edges", {}},      {"field", {}},      {"table", {}},
                   {"likelihood", {}}, {"refinement", {}}, {"rest of the filter", {}},
                   {"update", {}}};
  auto input = std::make_unique<SequenceInput>(
      sequence, SequenceParts{map->usesImages(), true, map->usesDepth()});
  const RecordedStart start{input->initialPose(), std::nullopt};
  RecordedLocalizer localizer(map, std::move(input), start);
  for (size_t i = 0; i < images && localizer.next(); ++i) {
    const LiveResult& r = localizer.result();
    if (!r.updated) continue;
    const StageTimes& t = r.image_times;
    const double rest = r.report.total_ms - r.report.likelihood_ms - r.report.refinement_ms;
    const double all = t.edges + t.field + t.table + r.report.total_ms;
    size_t k = 0;
    for (const double ms :
         {t.edges, t.field, t.table, r.report.likelihood_ms, r.report.refinement_ms, rest, all})
      table.stages_[k++].second.push_back(ms);
  }
  for (auto& stage : table.stages_) std::sort(stage.second.begin(), stage.second.end());
  return table;
}

double StageTable::percentile(const std::string& stage, double q) const {
  for (const auto& [name, ms] : stages_)
    if (name == stage && !ms.empty())
      return ms[static_cast<size_t>(std::lround(q * static_cast<double>(ms.size() - 1)))];
  return 0;
}

nlohmann::json StageTable::toJson() const {
  nlohmann::json json;
  for (const auto& stage : stages_)
    json[stage.first] = {{"p50", percentile(stage.first, 0.50)},
                         {"p95", percentile(stage.first, 0.95)},
                         {"p99", percentile(stage.first, 0.99)}};
  return json;
}

void StageTable::print(const std::string& title) const {
  if (empty()) return;
  std::printf("  %-42s %10s %10s %10s\n", title.c_str(), "p50 ms", "p95 ms", "p99 ms");
  for (const auto& stage : stages_)
    std::printf("  %-42s %10.2f %10.2f %10.2f\n", ("  " + stage.first).c_str(),
                percentile(stage.first, 0.50), percentile(stage.first, 0.95),
                percentile(stage.first, 0.99));
}

}  // namespace edge_mcl
