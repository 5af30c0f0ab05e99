/// Runs MRPT's own six-dimensional particle filter.
#pragma once

#include <mrpt/maps/CMetricMap.h>
#include <mrpt/obs/CObservation.h>

#include <functional>

#include "edge_mcl/comparison/compared_filter.h"
#include "edge_mcl/core/mesh/mesh_model.h"

namespace edge_mcl {

/// mrpt::slam::CMonteCarloLocalization3D as MRPT ships it on a metric map: standard proposal,
/// systematic resampling when the effective sample size is below half of the particles. Its poses
/// are poses of a body with x forward and z up, so that their angles stay far from the singularity.
class MrptFilter3D : public ComparedFilter {
 public:
  /// Makes an observation of the map from a moment; the pose of its sensor is opticalOnBody(). It
  /// returns null when there are no data; then the filter only predicts.
  using Observe = std::function<mrpt::obs::CObservation::Ptr(const LiveInput&)>;

  /// @param power exponent of the likelihood, MRPT's powFactor.
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

/// Makes a mrpt::maps::CSimplePointsMap of the model's surfaces. @param spacing largest distance of
/// neighbouring points, m. @param sigma standard deviation of a point's distance, m.
mrpt::maps::CMetricMap::Ptr pointMapOf(const MeshModel& mesh, double spacing, double sigma);
/// Observes the points of edge_mcl's depth cue as CObservationPointCloud.
MrptFilter3D::Observe observePoints(const DepthParameters& params);
/// Observes the image and its mask as CObservationMaskedImage.
MrptFilter3D::Observe observeImages();

}  // namespace edge_mcl
