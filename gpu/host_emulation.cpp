#include "host_emulation.h"

namespace edge_mcl::gpu {

namespace {

/// Sum over the lanes in the order of the device's butterfly of exchanges.
float sumOfLanes(float* lane) {
  for (int step = kTeamLanes / 2; step > 0; step /= 2) {
    float next[kTeamLanes];
    for (int i = 0; i < kTeamLanes; ++i) next[i] = lane[i] + lane[i ^ step];
    for (int i = 0; i < kTeamLanes; ++i) lane[i] = next[i];
  }
  return lane[0];
}

PartialLine scoreLine(const Workload& w, const Pose& pose, uint32_t begin, uint32_t end) {
  float score[kTeamLanes], weight[kTeamLanes];
  for (int lane = 0; lane < kTeamLanes; ++lane) {
    PartialLine sum{0, 0};
    for (uint32_t s = begin; s < end; ++s)
      addSample(w.camera, w.table, w.pairs.data(), w.rule, pose, w.segments[s], w.along.data(),
                lane, &sum);
    score[lane] = sum.score;
    weight[lane] = sum.weight;
  }
  return {sumOfLanes(score), sumOfLanes(weight)};
}

}  // namespace

std::vector<Result> emulate(const Workload& w, int teams) {
  std::vector<Result> results;
  results.reserve(w.particles.size());
  for (const Particle& particle : w.particles) {
    const Cell& cell = w.cells[particle.cell];
    Pose pose{};
    for (int i = 0; i < 12; ++i) fillPose(particle, cell, i, &pose);
    std::vector<LineSums> sums(teams, LineSums{0, 0, 0, 0});
    for (uint32_t g = 0; g < cell.group_count; ++g) {
      const uint32_t* ends = &w.group_ends[cell.first_group];
      const uint32_t begin = g == 0 ? 0 : ends[g - 1];
      closeLine(w.rule,
                scoreLine(w, pose, cell.first_segment + begin, cell.first_segment + ends[g]),
                &sums[g % teams]);
    }
    results.push_back(combineTeams(w.rule, w.combination, sums.data(), teams));
  }
  return results;
}

}  // namespace edge_mcl::gpu
