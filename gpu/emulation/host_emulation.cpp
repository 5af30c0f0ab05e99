#include "edge_mcl/gpu/emulation/host_emulation.h"

#include <algorithm>
#include <array>

namespace edge_mcl::gpu {

namespace {

/// Adds up the lanes in the order of the device's butterfly exchange.
template <class T>
T sumOfLanes(std::array<T, kLanes> lane) {
  for (int step = kLanes / 2; step > 0; step /= 2) {
    std::array<T, kLanes> next;
    for (int i = 0; i < kLanes; ++i) next[i] = lane[i] + lane[i ^ step];
    lane = next;
  }
  return lane[0];
}

/// A warp. All lanes do the same, one after the other.
class Warp {
 public:
  Warp(const Workload& w, const Quad* quads, const Cell& cell, const Pose& pose)
      : w_(w), quads_(quads), cell_(cell), pose_(pose) {
    own_.fill({0, 0, 0, 0});
  }

  void scorePart(int part) {
    OpenLine open{{0, 0}, kNoLine};
    for (uint32_t c = part == 0 ? 0 : cell_.part_end[part - 1]; c < cell_.part_end[part]; ++c)
      if (mayBeInView(w_.camera, pose_, w_.chunks[cell_.first_chunk + c]))
        scoreChunk(cell_.first_chunk + c, &open);
    if (open.line != kNoLine) closeLine(w_.rule, open.sum, &own_[0]);
  }

  double sum() const {
    std::array<double, kLanes> sums;
    for (int i = 0; i < kLanes; ++i) sums[i] = static_cast<double>(own_[i].sum) + own_[i].error;
    return sumOfLanes(sums);
  }
  float of(float LineSums::*member) const {
    std::array<float, kLanes> values;
    for (int i = 0; i < kLanes; ++i) values[i] = own_[i].*member;
    return sumOfLanes(values);
  }

 private:
  using Lanes = std::array<PartialLine, kLanes>;

  static Lanes sumOfLine(Lanes lane, const std::array<int, kLanes>& start) {
    for (int step = 1; step < kLanes; step *= 2) {
      const Lanes before = lane;
      for (int i = kLanes - 1; i >= step; --i)
        if (i - step >= start[i]) {
          lane[i].score += before[i - step].score;
          lane[i].weight += before[i - step].weight;
        }
    }
    return lane;
  }

  void scoreChunk(uint32_t number, OpenLine* open) {
    const Chunk& chunk = w_.chunks[number];
    Lanes line;
    line.fill({0, 0});
    for (uint32_t i = 0; i < chunk.count; ++i)
      line[i] = scoreOf(w_.camera, w_.table, quads_, w_.rule, pose_,
                        w_.samples[static_cast<size_t>(number) * kLanes + i]);
    if (std::none_of(line.begin(), line.end(), [](const PartialLine& p) { return p.weight > 0; }))
      return;
    const uint32_t heads = chunk.heads | 1u;
    std::array<int, kLanes> start{};
    for (int i = 1; i < kLanes; ++i) start[i] = (heads >> i & 1u) ? i : start[i - 1];
    line = sumOfLine(line, start);
    if (open->line == chunk.first_line) {
      for (int i = 0; i < kLanes && start[i] == 0; ++i) {
        line[i].score += open->sum.score;
        line[i].weight += open->sum.weight;
      }
    } else if (open->line != kNoLine) {
      closeLine(w_.rule, open->sum, &own_[0]);
    }
    for (int i = 0; i + 1 < kLanes; ++i)
      if (heads >> (i + 1) & 1u) closeLine(w_.rule, line[i], &own_[i]);
    *open = {line[kLanes - 1], chunk.last_line};
  }

  const Workload& w_;
  const Quad* quads_;
  const Cell& cell_;
  const Pose& pose_;
  std::array<LineSums, kLanes> own_;
};

}  // namespace

std::vector<Result> emulate(const Workload& w, const std::vector<Quad>& quads, int warps) {
  std::vector<Result> results;
  results.reserve(w.particles.size());
  for (const Particle& particle : w.particles) {
    const Cell& cell = w.cells[particle.cell];
    Pose pose{};
    for (int i = 0; i < 12; ++i) fillPose(particle, cell, i, &pose);
    double sum = 0;
    float lines = 0, weight = 0;
    for (int first = 0; first < kParts; first += kParts / warps) {
      Warp warp(w, quads.data(), cell, pose);
      for (int part = first; part < first + kParts / warps; ++part) warp.scorePart(part);
      sum += warp.sum();
      lines += warp.of(&LineSums::count);
      weight += warp.of(&LineSums::weight);
    }
    results.push_back(combine(w.rule, w.combination, sum, lines, weight));
  }
  return results;
}

}  // namespace edge_mcl::gpu
