/// What a depth image sees in front of the model (people, furniture, boxes), and what of the model.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "edge_mcl/core/base/parameters.h"
#include "edge_mcl/core/base/se3.h"
#include "edge_mcl/core/depth/depth_points.h"
#include "edge_mcl/core/mesh/ray_mesh.h"

namespace edge_mcl {

/// Points of a depth image that lie in front of the model. All points are in the optical frame of
/// the depth camera, m.
struct ForeignPoints {
  std::vector<Eigen::Vector3f> points;
  /// Points that lie on a surface of the model.
  std::vector<Eigen::Vector3f> of_model;
  /// Share of the compared pixels that are not foreign and lie on the model. At a right pose it is
  /// nearly 1. At a wrong pose many pixels lie behind the model.
  double agreement = 0;
  double spacing = 0;   ///< between neighbouring points in the depth image, pixels
  size_t compared = 0;  ///< pixels that have a depth, and a surface of the model behind them
};

/// Compares a depth image with the depth that the model has from the same pose.
///
/// A pixel is foreign when the model is farther away, by more than `least` and three standard
/// deviations of the noise of the depth and of what the uncertainty of the pose moves. Where the
/// model has no surface, nothing is foreign. Foreign pixels count where they form a region that is
/// at least three examined pixels wide somewhere: the depth at the edges of surfaces is seldom
/// right. A pixel is of the model when both depths differ by less than half of `least` and the
/// standard deviations. Beside an outline the surfaces on either side count. The mask of the depth
/// image is not used.
/// @param scene faces of the model. @param T_map_depth pose with its covariance in the tangent
/// space of the camera, m^2 and rad^2. @param least m.
/// @param lists_model false: `of_model` stays empty, which saves a third of the time.
/// @throws InputError when the type or size of the depth image is wrong.
ForeignPoints foreignPoints(const DepthImage& image, const RayScene& scene,
                            const PoseGaussian& T_map_depth, const DepthParameters& params,
                            double least, bool lists_model = true);

}  // namespace edge_mcl
