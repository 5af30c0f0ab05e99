/// The 3D model as an MRPT metric map.
#pragma once

#include <mrpt/maps/CMetricMap.h>
#include <mrpt/maps/TMetricMapInitializer.h>
#include <mrpt/maps/TMetricMapTypesRegistry.h>
#include <mrpt/obs/CObservation.h>

#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "edge_mcl/core/localization_map.h"

namespace edge_mcl {

/// Scores camera images (CObservationImage, CObservationMaskedImage, and the intensity image of
/// CObservation3DRangeScan) against the edges of a 3D model, and range images of
/// CObservation3DRangeScan against its surfaces (likelihood.cues: edges, depth or both).
///
/// In an MRPT ini file, as map number 00 of section [MetricMap]:
/// @code
/// [MetricMap]
/// edge_mcl::CEdgeMap_count = 1
/// [MetricMap_edge_mcl::CEdgeMap_00_creationOpts]
/// model_file = building.obj
/// camera_file = camera.yaml       ; calibration of images that come without; may be left out
/// likelihood.model = robust       ; any parameter of `edge-mcl parameters`
/// @endcode
/// The library must be loaded before MRPT reads the file: link to it, or LD_PRELOAD it.
///
/// Log-likelihoods are pure functions of image and pose; the edges and the table of an image are
/// made once and kept until another image comes. Safe to call from several threads.
class CEdgeMap : public mrpt::maps::CMetricMap {
  DEFINE_SERIALIZABLE(CEdgeMap, edge_mcl)

 public:
  CEdgeMap() = default;
  /// @throws InputError, ParameterError
  CEdgeMap(const std::string& model_file, const Parameters& params);

  void load(const std::string& model_file, const Parameters& params);
  /// Calibration of images that come without. Empty: they are an error. @throws InputError
  void useCamera(const std::string& camera_file);
  /// @throws Error when no model is loaded.
  const LocalizationMap& localization() const;
  const std::string& modelFile() const { return model_file_; }

  /// The observation's image and range image, as far as likelihood.cues uses them, prepared; empty
  /// for other observations. @throws InputError on a broken image, mask or camera.
  std::vector<CameraView> views(const mrpt::obs::CObservation& obs) const;

  /// Log-likelihood of many robot poses (T_map_base) at once: the same numbers that
  /// computeObservationLikelihood gives one by one.
  std::vector<double> logLikelihoods(const mrpt::obs::CObservation& obs,
                                     const std::vector<Pose>& base_poses) const;

  bool isEmpty() const override { return !map_; }
  std::string asString() const override;
  void getVisualizationInto(mrpt::opengl::CSetOfObjects& out) const override;
  /// Writes PREFIX_edges.obj: the feature lines as line elements.
  void saveMetricMapRepresentationToFile(const std::string& prefix) const override;

 private:
  void internal_clear() override;
  bool internal_insertObservation(
      const mrpt::obs::CObservation& obs,
      const std::optional<const mrpt::poses::CPose3D>& robot_pose) override;
  double internal_computeObservationLikelihood(
      const mrpt::obs::CObservation& obs, const mrpt::poses::CPose3D& taken_from) const override;
  bool internal_canComputeObservationLikelihood(const mrpt::obs::CObservation& obs) const override;

  std::string model_file_, camera_file_;
  std::optional<CameraModel> camera_;
  std::shared_ptr<const LocalizationMap> map_;

  /// The last image and depth, recognised by address, time and a sample of the image's pixels.
  struct ImageCache {
    std::mutex mutex;
    uint64_t image_key = 0, depth_key = 0;
    std::shared_ptr<const PreparedImage> image;
    std::shared_ptr<const DepthPoints> depth;
  };
  std::shared_ptr<ImageCache> cache_ = std::make_shared<ImageCache>();

  MAP_DEFINITION_START(CEdgeMap)
  std::string model_file, camera_file;
  Parameters params;
  MAP_DEFINITION_END(CEdgeMap)
};

}  // namespace edge_mcl
