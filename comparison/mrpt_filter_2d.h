/// Runs MRPT's own planar particle filter on an occupancy grid.
#pragma once

#include <mrpt/maps/COccupancyGridMap2D.h>
#include <mrpt/obs/CObservation2DRangeScan.h>

#include "edge_mcl/comparison/compared_filter.h"
#include "edge_mcl/core/mesh/mesh_model.h"

namespace edge_mcl {

/// Parameters of the grid and the scan.
struct FloorPlanParameters {
  double cell = 0.01;              ///< size of a grid cell, m
  double slab = 0.1;               ///< m; points this near to the grid's height make the scan
  double ray_deg = 1;              ///< angle between rays
  double field_of_view_deg = 120;  ///< of the scan
  double sigma_hit = 0.05;         ///< m, LF_stdHit of MRPT's likelihood field
};

/// Makes an occupancy grid of the section through the model at a height (map z, m).
mrpt::maps::COccupancyGridMap2D::Ptr floorPlanOf(const MeshModel& mesh, double height,
                                                 const FloorPlanParameters& params);

/// Makes the scan that a horizontal scanner at the camera would measure at the height of the grid.
/// The range of a ray is the median of the depth points near this height in its direction.
/// @param points camera frame, m. @param level_camera T_map_camera with heading 0 and x = y = 0.
/// @param height of the grid, map z, m. @return null when fewer than 5 rays have a point.
mrpt::obs::CObservation2DRangeScan::Ptr scanOf(const DepthPoints& points, const Pose& level_camera,
                                               double height, const FloorPlanParameters& params);

/// mrpt::slam::CMonteCarloLocalization2D as MRPT ships it. It estimates x, y and heading. It gets
/// height, roll and pitch from the ground truth, as from a perfect altimeter and a perfect IMU.
class MrptFilter2D : public ComparedFilter {
 public:
  /// @param height of the grid, map z, m. @param power exponent of the likelihood, MRPT's
  /// powFactor.
  MrptFilter2D(const MeshModel& mesh, double height, const FilterParameters& params,
               const DepthParameters& depth, const FloorPlanParameters& plan, double power);
  ~MrptFilter2D() override;
  void initialize(const PoseGaussian& start) override;
  Pose process(const LiveInput& input, const Pose& truth) override;

 private:
  struct Filter;
  double height_;
  FilterParameters params_;
  DepthParameters depth_;
  FloorPlanParameters plan_;
  MotionSource motion_;
  std::optional<Pose> last_level_;  // body with heading 0
  std::unique_ptr<Filter> filter_;
};

}  // namespace edge_mcl
