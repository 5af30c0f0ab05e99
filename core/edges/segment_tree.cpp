#include "edge_mcl/core/edges/segment_tree.h"

#include <limits>
#include <numeric>

namespace edge_mcl {

namespace {

/// Box of all samples of a segment.
Box boxOf(const EdgeModel& model, const EdgeSegment& segment) {
  return {segment.centre, segment.radius * model.lines[segment.line].tangent().cwiseAbs()};
}

}  // namespace

SegmentTree::SegmentTree(const EdgeModel& model) {
  const size_t count = model.segments.size();
  std::vector<Box> boxes;
  boxes.reserve(count);
  for (const EdgeSegment& segment : model.segments) boxes.push_back(boxOf(model, segment));
  order_.resize(count);
  std::iota(order_.begin(), order_.end(), 0u);
  if (count > 0) build(boxes, 0, static_cast<uint32_t>(count));
}

uint32_t SegmentTree::build(const std::vector<Box>& boxes, uint32_t first, uint32_t count) {
  constexpr uint32_t kLeaf = 8;
  Eigen::Vector3f low = Eigen::Vector3f::Constant(std::numeric_limits<float>::max()), high = -low;
  for (uint32_t i = first; i < first + count; ++i) {
    const Box& box = boxes[order_[i]];
    low = low.cwiseMin(box.centre - box.half);
    high = high.cwiseMax(box.centre + box.half);
  }
  const auto index = static_cast<uint32_t>(nodes_.size());
  // Sums in single precision are rounded by this much.
  const float rounding = 4 * std::numeric_limits<float>::epsilon() *
                         low.cwiseAbs().cwiseMax(high.cwiseAbs()).maxCoeff();
  const Eigen::Vector3f half = 0.5f * (high - low) + Eigen::Vector3f::Constant(rounding);
  nodes_.push_back({{0.5f * (low + high), half}, first, count, 0});
  if (count <= kLeaf) return index;
  int axis = 0;
  (high - low).maxCoeff(&axis);
  const auto begin = order_.begin() + first;
  std::nth_element(begin, begin + count / 2, begin + count, [&](uint32_t a, uint32_t b) {
    return boxes[a].centre[axis] != boxes[b].centre[axis]
               ? boxes[a].centre[axis] < boxes[b].centre[axis]
               : a < b;
  });
  build(boxes, first, count / 2);
  const uint32_t right = build(boxes, first + count / 2, count - count / 2);
  nodes_[index].right = right;
  return index;
}

}  // namespace edge_mcl
