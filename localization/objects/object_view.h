/// What one image tells about a foreign object: where its middle is, how large it is, how it looks.
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "edge_mcl/core/depth/foreign_points.h"
#include "edge_mcl/localization/objects/point_clusters.h"

namespace edge_mcl {

/// A depth image at a trusted pose, and what it sees in front of the model.
struct ForeignDepth {
  DepthImage image;
  ForeignPoints foreign;
  Pose T_map_depth = Pose::Identity();
};

/// An image at a trusted pose.
struct ForeignColour {
  cv::Mat image;  ///< CV_8U or CV_8UC3 (BGR); others tell nothing
  CameraModel camera;
  Pose T_map_camera = Pose::Identity();
};

/// Size of an object as it is seen: across the view, along the view, upwards; m.
using SeenSize = Eigen::Vector3d;

/// The visible side of an object in one depth image.
///
/// A camera sees only the side of an object that faces it. So the middle is found from the visible
/// faces and from a size that earlier images have shown.
class ObjectSide {
 public:
  /// @param cluster its points; not empty
  ObjectSide(const PointCluster& cluster, const ForeignDepth& view);

  /// The middle of an object of this size, map frame, m.
  Eigen::Vector3d middle(const SeenSize& size) const;
  /// The box of an object of this size around a middle, in the axes of the map.
  Eigen::AlignedBox3d boxAround(const Eigen::Vector3d& middle, const SeenSize& size) const;
  /// The size, where the image shows it. The depth of an object is at least 0.7 of its width, but
  /// for wide ones: its back is hidden. @param before from earlier images; none: this is the first
  SeenSize learn(const std::optional<SeenSize>& before) const;
  /// Whether the border of the image cuts the object off, above or below.
  bool isCutAbove() const { return cut_above_; }
  bool isCutBelow() const { return cut_below_; }

 private:
  Eigen::Vector3d eye_, right_, forward_;                  // right and forward are horizontal
  double left_end_, right_end_, near_, far_, low_, high_;  // m, along these axes
  bool cut_left_ = false, cut_right_ = false, cut_above_ = false, cut_below_ = false;
};

/// What a depth image tells about a point of the map.
struct Sight {
  enum class Kind {
    kUnknown,  ///< outside the image, or no depth there
    kHidden,   ///< something is far in front of it
    kThere,    ///< a surface is there, or a little in front of it
    kFree      ///< the image shows what is behind
  };
  Kind kind = Kind::kUnknown;
  /// What the image shows there, map frame, m. Without a meaning for kUnknown.
  Eigen::Vector3d surface = Eigen::Vector3d::Zero();
};
/// @param tolerance difference of depth that still counts as there, m; the noise of the depth is
/// added. @param point map frame, m
Sight lookAt(const ForeignDepth& view, const Eigen::Vector3d& point, double tolerance,
             const DepthParameters& params);

/// Shares of hues and brightnesses.
using Appearance = std::vector<float>;
/// @return empty when no point is in view, or the image cannot be used.
Appearance appearanceOf(const PointCluster& cluster, const ForeignColour& view);
/// 0: equal; 1: nothing in common (Hellinger distance). 0 when one of them is empty.
double differenceOf(const Appearance& a, const Appearance& b);

}  // namespace edge_mcl
