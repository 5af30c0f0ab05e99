/// The objects that training images are made of, ready for the ray caster.
#pragma once

#include <embree3/rtcore.h>

#include <string>
#include <vector>

#include "edge_mcl/core/mesh/mesh_model.h"

namespace edge_mcl {

/// Classes of the labels; 0 is background.
constexpr const char* kTrainingClasses[] = {"background", "person",   "sofa",
                                            "chair",      "computer", "screen"};

/// A mesh, standing on z = 0, centred in x and y.
struct TrainingObject {
  int label = 0;
  float elevation = 0;  ///< m, where it hangs on a wall
  Eigen::Vector3f size;
  MeshModel mesh;
  std::vector<Eigen::Vector3f> normals;
  RTCScene scene = nullptr;
};

/// Reads index.txt of objects.py; a file that cannot be read is left out with a warning.
class TrainingObjects {
 public:
  /// @param split "train" or "test"; background serves both. @throws InputError when the index is
  /// missing or broken, or a class has no object.
  TrainingObjects(const std::string& directory, const std::string& split);
  ~TrainingObjects();
  TrainingObjects(const TrainingObjects&) = delete;
  TrainingObjects& operator=(const TrainingObjects&) = delete;

  RTCDevice device() const { return device_; }
  const std::vector<TrainingObject>& ofClass(int label) const {
    return by_class_.at(static_cast<size_t>(label));
  }

 private:
  RTCDevice device_ = nullptr;
  std::vector<std::vector<TrainingObject>> by_class_;
};

/// A committed ray-caster scene of one mesh.
RTCScene makeScene(RTCDevice device, const MeshModel& mesh, RTCBuildQuality quality);
std::vector<Eigen::Vector3f> faceNormals(const MeshModel& mesh);

}  // namespace edge_mcl
