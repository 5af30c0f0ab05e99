/// MRPT's own planar particle filter on an occupancy grid.
#pragma once

#include <mrpt/maps/COccupancyGridMap2D.h>
#include <mrpt/obs/CObservation2DRangeScan.h>

#include "edge_mcl/comparison/compared_filter.h"
#include "edge_mcl/core/mesh/mesh_model.h"

namespace edge_mcl {

/// How the plan and the scan are made.
struct FloorPlanParameters {
  double cell = 0.01;  ///< m, of the grid
  double slab = 0.1;   ///< m; depth points this near to the plan's height make the scan
  double ray_deg = 1;  ///< between rays
  double field_of_view_deg = 120;
  double sigma_hit = 0.05;  ///< m, LF_stdHit of MRPT's likelihood field
};

/// An occupancy grid cut out of the model at a height (map z, m).
mrpt::maps::COccupancyGridMap2D::Ptr floorPlanOf(const MeshModel& mesh, double height,
                                                 const FloorPlanParameters& params);

/// The depth image as a horizontal scanner at the camera would see it in the plan's height: of the
/// points near that height, the median range per ray.
/// @param level_camera the camera with heading 0, at (0, 0, its height). @return nothing where
/// hardly a ray hits.
mrpt::obs::CObservation2DRangeScan::Ptr scanOf(const DepthPoints& points, const Pose& level_camera,
                                               double height, const FloorPlanParameters& params);

/// mrpt::slam::CMonteCarloLocalization2D as MRPT ships it. It knows x, y and heading; height, roll
/// and pitch are given to it from the truth, as if an altimeter and an IMU were perfect.
class MrptFilter2D : public ComparedFilter {
 public:
  /// @param height of the plan. @param power of the likelihood, MRPT's powFactor.
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
