#include "edge_mcl/gpu/backend/workload_export.h"

#include <map>
#include <utility>

#include "edge_mcl/gpu/backend/cell_packing.h"
#include "edge_mcl/gpu/backend/conversion.h"

namespace edge_mcl::gpu {

Workload makeWorkload(const std::string& name, const Visibility& visibility,
                      const LikelihoodFrame& frame, const std::vector<edge_mcl::Pose>& camera_poses,
                      const std::vector<PoseScore>& reference, const Picture* picture) {
  Workload w;
  w.name = name;
  w.camera = cameraOf(frame.camera);
  const std::shared_ptr<const ScoreTable> table = frame.tableHere();
  w.table = tableOf(*table);
  w.rule = ruleOf(frame);
  w.combination = combinationOf(frame.params);
  w.pairs.assign(table->pairs(), table->pairs() + table->pairCount());
  if (picture && canMakeTables(picture->params())) {
    w.recipe =
        recipeOf(frame.camera.width, frame.camera.height, picture->params(), *picture->levels());
    for (const auto& [image, bytes] :
         {std::pair{&picture->grey(), &w.grey}, {&picture->ignore(), &w.ignore}})
      for (int y = 0; y < image->rows; ++y)
        bytes->insert(bytes->end(), image->ptr<uint8_t>(y), image->ptr<uint8_t>(y) + image->cols);
  }
  std::map<CellKey, uint32_t> numbers;
  for (const edge_mcl::Pose& pose : camera_poses) {
    const CellKey key = visibility.cellOf(pose.translation());
    const auto [entry, fresh] = numbers.emplace(key, static_cast<uint32_t>(w.cells.size()));
    if (fresh) {
      CellData data = packCell(*visibility.cached(key), visibility.cellCentre(key), frame.thinning);
      data.cell.first_chunk = static_cast<uint32_t>(w.chunks.size());
      w.cells.push_back(data.cell);
      w.chunks.insert(w.chunks.end(), data.chunks.begin(), data.chunks.end());
      w.samples.insert(w.samples.end(), data.samples.begin(), data.samples.end());
    }
    w.particles.push_back(particleOf(pose, entry->second));
  }
  for (const PoseScore& score : reference) w.reference.push_back(score.log_likelihood);
  return w;
}

}  // namespace edge_mcl::gpu
