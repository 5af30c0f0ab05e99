/// Hierarchy of boxes over the segments of an edge model.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cstdint>
#include <vector>

#include "edge_mcl/core/edges/edge_model.h"

namespace edge_mcl {

/// An axis-parallel box, map frame, metres.
struct Box {
  Eigen::Vector3f centre = Eigen::Vector3f::Zero(), half = Eigen::Vector3f::Zero();
};

/// Lets a visitor leave out whole parts of a building. A model of a million segments is a tree of
/// about twenty levels.
class SegmentTree {
 public:
  explicit SegmentTree(const EdgeModel& model);

  /// Visits the boxes from the whole model downwards, and lists the segments in the smallest boxes
  /// that are kept. Such a box holds up to eight segments.
  /// @param keep called with a Box; false: none of its segments is needed
  /// @return numbers of the segments, ascending
  template <class Keep>
  std::vector<uint32_t> find(Keep&& keep) const;

 private:
  struct Node {
    Box box;
    uint32_t first = 0, count = 0;  // segments in order_
    uint32_t right = 0;             // right child; the left one is the next node; 0: a leaf
  };
  /// @param boxes of the segments. @return number of the node
  uint32_t build(const std::vector<Box>& boxes, uint32_t first, uint32_t count);

  std::vector<uint32_t> order_;  // segments, those of a node side by side
  std::vector<Node> nodes_;      // parents before children
};

template <class Keep>
std::vector<uint32_t> SegmentTree::find(Keep&& keep) const {
  std::vector<uint32_t> found, open;
  if (!nodes_.empty()) open.push_back(0);
  while (!open.empty()) {
    const uint32_t index = open.back();
    open.pop_back();
    const Node& node = nodes_[index];
    if (!keep(node.box)) continue;
    if (node.right == 0) {
      const auto first = order_.begin() + node.first;
      found.insert(found.end(), first, first + node.count);
      continue;
    }
    open.push_back(node.right);
    open.push_back(index + 1);
  }
  std::sort(found.begin(), found.end());
  return found;
}

}  // namespace edge_mcl
