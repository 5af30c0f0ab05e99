/// Straight lines of the map from the segments of many images.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "edge_mcl/mapping/depth_segments.h"

namespace edge_mcl {

/// A straight line of a map.
struct MappedLine {
  Eigen::Vector3d start, end;  ///< map, metres
  double sigma = 0;            ///< standard deviation of its position across the line, m
  size_t views = 0;            ///< images that have seen it
};

struct TrackOptions {
  /// Images that must have seen a piece of a line. Outlines of curved surfaces and reflections move
  /// with the camera, so few images agree on them.
  size_t min_views = 4;
  double max_angle_deg = 6;    ///< between segments of one line
  double max_distance = 0.03;  ///< across, between segments of one line, m
  double max_gap = 0.1;        ///< along, between segments of one line, m
  double pixel_sigma = 2;      ///< of the image segments, with the error of the poses, px
  double focal = 525;          ///< px, turns pixel_sigma into an angle
  double min_length = 0.08;    ///< m
  /// A line this near to another one that more images have seen is the same edge once more, m.
  double same_distance = 0.015;
};

/// Joins segments that belong to one line, estimates the line from the image planes and the depths
/// of all of them, and keeps the pieces that enough images have seen. The result depends on the
/// order of the segments only where two lines are equally near.
std::vector<MappedLine> trackLines(const std::vector<DepthSegment>& segments,
                                   const TrackOptions& options);

}  // namespace edge_mcl
