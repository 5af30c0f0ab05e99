#include "edge_mcl/gpu/workload_export.h"

#include <map>

#include "edge_mcl/gpu/conversion.h"

namespace edge_mcl::gpu {

Workload makeWorkload(const std::string& name, const Visibility& visibility,
                      const LikelihoodFrame& frame, const std::vector<edge_mcl::Pose>& camera_poses,
                      const std::vector<PoseScore>& reference) {
  Workload w;
  w.name = name;
  w.camera = cameraOf(frame.camera);
  w.table = tableOf(*frame.table);
  w.rule = ruleOf(frame);
  w.combination = combinationOf(frame.params);
  w.pairs.assign(frame.table->pairs(), frame.table->pairs() + frame.table->pairCount());
  w.along = visibility.model().sample_along;
  std::map<CellKey, uint32_t> numbers;
  for (const edge_mcl::Pose& pose : camera_poses) {
    const CellKey key = visibility.cellOf(pose.translation());
    const auto [entry, fresh] = numbers.emplace(key, static_cast<uint32_t>(w.cells.size()));
    if (fresh) {
      CellData data = cellOf(*visibility.cached(key), visibility.cellCentre(key));
      data.cell.first_segment = static_cast<uint32_t>(w.segments.size());
      data.cell.first_group = static_cast<uint32_t>(w.group_ends.size());
      w.cells.push_back(data.cell);
      w.segments.insert(w.segments.end(), data.segments.begin(), data.segments.end());
      w.group_ends.insert(w.group_ends.end(), data.group_ends.begin(), data.group_ends.end());
    }
    w.particles.push_back(particleOf(pose, entry->second));
  }
  for (const PoseScore& score : reference) w.reference.push_back(score.log_likelihood);
  return w;
}

}  // namespace edge_mcl::gpu
