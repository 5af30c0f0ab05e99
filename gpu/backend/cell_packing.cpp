#include "edge_mcl/gpu/backend/cell_packing.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace edge_mcl::gpu {

namespace {

struct Line {
  std::vector<Sample> samples;
  uint32_t direction = 0;  // see directionNumber(); close numbers mean close directions
};

Eigen::Vector3f positionOf(const Sample& s) {
  return Eigen::Vector3f(s.centre) + s.along * Eigen::Vector3f(s.tangent);
}

/// Returns a number for a direction: interleaves five bits of each of its coordinates (Morton
/// order).
uint32_t directionNumber(const Eigen::Vector3f& towards) {
  const float norm = towards.norm();
  if (!(norm > 0)) return 0;
  uint32_t number = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const auto share = static_cast<uint32_t>(15.99F * (1 + towards[axis] / norm));
    for (uint32_t bit = 0; bit < 5; ++bit) number |= (share >> bit & 1u) << (3 * bit + axis);
  }
  return number;
}

std::vector<Line> linesOf(const VisibleSet& set, const Eigen::Vector3d& origin, uint32_t thinning) {
  std::vector<Line> lines;
  Line line;
  for (size_t k = 0; k < set.segments.size(); ++k) {
    const VisibleSet::Segment& seen = set.segments[k];
    const EdgeSegment& edge = set.edgeSegment(seen);
    const Eigen::Vector3f centre = (edge.centre.cast<double>() - origin).cast<float>();
    const Eigen::Vector3f tangent = set.line(seen).tangent();
    const uint32_t used = seen.samples & usedSamples(edge, thinning);
    for (uint32_t i = 0; i < edge.sample_count; ++i) {
      if (!(used >> i & 1u)) continue;
      Sample s{};
      std::copy_n(centre.data(), 3, s.centre);
      std::copy_n(tangent.data(), 3, s.tangent);
      s.along = set.model->sample_along[edge.first_sample + i];
      s.weight = static_cast<float>(seen.facing) * (1 / 65535.0F);
      line.samples.push_back(s);
    }
    if (!set.endsGroup(k)) continue;
    if (!line.samples.empty()) {
      line.direction = directionNumber(positionOf(line.samples[line.samples.size() / 2]));
      lines.push_back(std::move(line));
    }
    line = Line();
  }
  return lines;
}

/// Adds a sample to the last chunk. Makes a new chunk when the last one is full or has a number
/// below `first`.
void append(const Sample& sample, uint32_t line, size_t first, CellData* data) {
  if (data->chunks.size() == first || data->chunks.back().count == kLanes) {
    Chunk fresh{};
    fresh.first_line = line;
    data->chunks.push_back(fresh);
    data->samples.resize(data->chunks.size() * kLanes, Sample{});
  }
  Chunk& chunk = data->chunks.back();
  if (chunk.count == 0 || chunk.last_line != line) chunk.heads |= 1u << chunk.count;
  data->samples[(data->chunks.size() - 1) * kLanes + chunk.count++] = sample;
  chunk.last_line = line;
}

void boundSamples(const Sample* samples, Chunk* chunk) {
  Eigen::Vector3f low = positionOf(samples[0]), high = low;
  for (uint32_t i = 1; i < chunk->count; ++i) {
    low = low.cwiseMin(positionOf(samples[i]));
    high = high.cwiseMax(positionOf(samples[i]));
  }
  const Eigen::Vector3f centre = 0.5F * (low + high);
  float radius = 0;
  for (uint32_t i = 0; i < chunk->count; ++i)
    radius = std::max(radius, (positionOf(samples[i]) - centre).norm());
  std::copy_n(centre.data(), 3, chunk->centre);
  // Margin for the rounding of coordinates up to about 100 m.
  chunk->radius = radius + 1e-4F + 1e-6F * centre.norm();
}

}  // namespace

CellData packCell(const VisibleSet& set, const Eigen::Vector3d& origin, uint32_t thinning) {
  CellData data;
  std::copy_n(origin.data(), 3, data.cell.origin);
  std::vector<Line> lines = linesOf(set, origin, thinning);
  std::stable_sort(lines.begin(), lines.end(),
                   [](const Line& a, const Line& b) { return a.direction < b.direction; });
  std::array<std::vector<uint32_t>, kParts> lines_of_part;
  std::array<size_t, kParts> size{};
  for (uint32_t k = 0; k < lines.size(); ++k) {
    const auto part =
        static_cast<size_t>(std::min_element(size.begin(), size.end()) - size.begin());
    lines_of_part[part].push_back(k);
    size[part] += lines[k].samples.size();
  }
  for (int part = 0; part < kParts; ++part) {
    const size_t first = data.chunks.size();
    for (const uint32_t k : lines_of_part[part])
      for (const Sample& s : lines[k].samples) append(s, k, first, &data);
    data.cell.part_end[part] = static_cast<uint32_t>(data.chunks.size());
  }
  for (size_t c = 0; c < data.chunks.size(); ++c)
    boundSamples(&data.samples[c * kLanes], &data.chunks[c]);
  data.cell.chunk_count = static_cast<uint32_t>(data.chunks.size());
  return data;
}

}  // namespace edge_mcl::gpu
