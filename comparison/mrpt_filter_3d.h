/// MRPT's own six-dimensional particle filter.
#pragma once

#include <mrpt/maps/CMetricMap.h>
#include <mrpt/obs/CObservation.h>

#include <functional>

#include "edge_mcl/comparison/compared_filter.h"
#include "edge_mcl/core/mesh/mesh_model.h"

namespace edge_mcl {

/// mrpt::slam::CMonteCarloLocalization3D as MRPT ships it (standard proposal, systematic
/// resampling below half of the effective sample size) on a metric map. It holds poses of a body
/// with x forward and z up, so that its angles stay far from their singularity.
class MrptFilter3D : public ComparedFilter {
 public:
  /// A moment as an observation of the map, the sensor's pose being opticalOnBody(); nothing where
  /// there is none: then it predicts only.
  using Observe = std::function<mrpt::obs::CObservation::Ptr(const LiveInput&)>;

  /// @param power of the likelihood, MRPT's powFactor.
  MrptFilter3D(mrpt::maps::CMetricMap::ConstPtr map, Observe observe,
               const FilterParameters& params, double power);
  ~MrptFilter3D() override;
  void initialize(const PoseGaussian& start) override;
  Pose process(const LiveInput& input, const Pose& truth) override;

 private:
  struct Filter;
  Observe observe_;
  FilterParameters params_;
  MotionSource motion_;
  std::unique_ptr<Filter> filter_;
};

/// The model's surfaces as mrpt::maps::CSimplePointsMap. @param spacing m.
mrpt::maps::CMetricMap::Ptr pointMapOf(const MeshModel& mesh, double spacing, double sigma);
/// The points that edge_mcl's own depth cue takes, as CObservationPointCloud.
MrptFilter3D::Observe observePoints(const DepthParameters& params);
/// The image and its mask, as CObservationMaskedImage.
MrptFilter3D::Observe observeImages();

}  // namespace edge_mcl
