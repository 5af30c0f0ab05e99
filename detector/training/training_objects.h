/// Loads the objects of the training images into the ray caster.
#pragma once

#include <string>
#include <vector>

#include "edge_mcl/core/mesh/embree.h"
#include "edge_mcl/core/mesh/mesh_model.h"

namespace edge_mcl {

/// Names of the classes by label; 0 is the background.
constexpr const char* kTrainingClasses[] = {"background", "person",   "sofa",
                                            "chair",      "computer", "screen"};

/// A mesh that stands on z = 0 and is centred in x and y.
struct TrainingObject {
  int label = 0;         ///< number of the class
  float elevation = 0;   ///< height of its lower side above the floor, m; not 0 on a wall
  Eigen::Vector3f size;  ///< m
  MeshModel mesh;
  std::vector<Eigen::Vector3f> normals;  ///< of the faces
  RTCScene scene = nullptr;
};

/// All objects of one split, from index.txt of objects.py. A mesh that cannot be read is left out
/// with a warning.
class TrainingObjects {
 public:
  /// @param directory folder of index.txt. @param split "train" or "test"; objects of the split
  /// "both" (the background) belong to both. @throws InputError when the index is missing or
  /// broken, or a class has no object.
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

/// Makes a committed ray-caster scene of one mesh. The caller must release it.
RTCScene makeScene(RTCDevice device, const MeshModel& mesh, RTCBuildQuality quality);
/// Unit normals of the faces.
std::vector<Eigen::Vector3f> faceNormals(const MeshModel& mesh);

}  // namespace edge_mcl
