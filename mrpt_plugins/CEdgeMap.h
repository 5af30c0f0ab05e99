/// A 3D model as an MRPT metric map.
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

/// MRPT metric map that scores observations against a 3D model. Camera images (CObservationImage,
/// CObservationMaskedImage, intensity image of CObservation3DRangeScan) are compared with the edges
/// of the model. Range images (CObservation3DRangeScan) are compared with its surfaces. The
/// parameter likelihood.cues says which of both are used: edges, depth or both.
///
/// Definition in an MRPT ini file, as map number 00 of section [MetricMap]:
/// @code
/// [MetricMap]
/// edge_mcl::CEdgeMap_count = 1
/// [MetricMap_edge_mcl::CEdgeMap_00_creationOpts]
/// model_file = building.obj
/// camera_file = camera.yaml       ; optional: calibration of images without one
/// likelihood.model = robust       ; any parameter of `edge-mcl parameters`
/// @endcode
/// The library must be loaded before MRPT reads the file: link to it, or load it with LD_PRELOAD.
///
/// A log-likelihood depends only on image and pose. The edges and the table of an image are made
/// once and kept until another image comes. Safe to call from several threads.
class CEdgeMap : public mrpt::maps::CMetricMap {
  DEFINE_SERIALIZABLE(CEdgeMap, edge_mcl)

 public:
  CEdgeMap() = default;
  /// Loads a model, see load().
  CEdgeMap(const std::string& model_file, const Parameters& params);

  /// Loads a model file. @throws InputError when the file cannot be used. @throws ParameterError
  /// when a parameter is not valid.
  void load(const std::string& model_file, const Parameters& params);
  /// Reads the calibration (YAML) of images that come without one. With an empty name these images
  /// are an error. @throws InputError when the file cannot be used.
  void useCamera(const std::string& camera_file);
  /// The model, with everything that scores poses in it. @throws Error when no model is loaded.
  const LocalizationMap& localization() const;
  const std::string& modelFile() const { return model_file_; }

  /// Prepares the image and the range image of an observation, if likelihood.cues uses them. The
  /// result is empty for other observations. @throws InputError when image, mask, range image or
  /// camera is not valid. @throws Error when no model is loaded.
  std::vector<CameraView> views(const mrpt::obs::CObservation& obs) const;

  /// Log-likelihoods (nats) of many robot poses (T_map_base), one per pose. They are the numbers
  /// that computeObservationLikelihood gives for single poses. @throws as views().
  std::vector<double> logLikelihoods(const mrpt::obs::CObservation& obs,
                                     const std::vector<Pose>& base_poses) const;

  bool isEmpty() const override { return !map_; }
  std::string asString() const override;
  void getVisualizationInto(mrpt::opengl::CSetOfObjects& out) const override;
  /// Writes the feature lines as line elements to PREFIX_edges.obj. @throws InputError when the
  /// file cannot be written.
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

  /// The last image and the last depth image, recognised by keyOf() and depthKeyOf().
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
