#include "edge_mcl/detector/training/training_objects.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <fstream>
#include <iostream>
#include <iterator>
#include <sstream>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/import/mesh_loader.h"
#include "edge_mcl/core/mesh/ray_mesh.h"

namespace edge_mcl {

namespace {

struct IndexLine {
  int label = 0;
  float elevation = 0;
  Eigen::Vector3f size;
  Eigen::Matrix3f to_z_up = Eigen::Matrix3f::Identity();
  std::string file;
};

IndexLine parse(const std::string& text, const std::string& origin, std::string* split) {
  std::istringstream in(text);
  std::string name, rotation;
  IndexLine line;
  const auto fail = [&] { throw InputError(origin + ": cannot read the line \"" + text + "\""); };
  std::string numbers;
  if (!std::getline(in, name, '\t') || !std::getline(in, *split, '\t') ||
      !(in >> line.size.x() >> line.size.y() >> line.size.z() >> line.elevation))
    fail();
  in.ignore(1, '\t');
  if (!std::getline(in, rotation, '\t') || !std::getline(in, line.file)) fail();
  const auto* found = std::find(std::begin(kTrainingClasses), std::end(kTrainingClasses), name);
  if (found == std::end(kTrainingClasses)) fail();
  line.label = static_cast<int>(found - std::begin(kTrainingClasses));
  if (rotation != "-") {
    Eigen::Matrix3f turn;
    std::istringstream values(rotation);
    for (int i = 0; i < 9; ++i)
      if (!(values >> turn(i / 3, i % 3))) fail();
    Eigen::Matrix3f up;  // y up, front along +z, becomes z up, front along -y
    up << 1, 0, 0, 0, 0, -1, 0, 1, 0;
    line.to_z_up = up * turn;
  }
  return line;
}

/// Turns the mesh to z up, scales it to the size of the index and puts it on z = 0, centred in x
/// and y.
void standUp(const IndexLine& line, MeshModel* mesh) {
  for (auto& v : mesh->vertices) v = line.to_z_up * v;
  Eigen::Vector3f low = mesh->vertices.front(), high = low;
  for (const auto& v : mesh->vertices) {
    low = low.cwiseMin(v);
    high = high.cwiseMax(v);
  }
  const Eigen::Vector3f extent = (high - low).cwiseMax(1e-6f);
  const Eigen::Vector3f factor = line.size.cwiseQuotient(extent);
  const Eigen::Vector3f middle(0.5f * (low.x() + high.x()), 0.5f * (low.y() + high.y()), low.z());
  for (auto& v : mesh->vertices) v = (v - middle).cwiseProduct(factor);
}

}  // namespace

RTCScene makeScene(RTCDevice device, const MeshModel& mesh, RTCBuildQuality quality) {
  RTCScene scene = rtcNewScene(device);
  rtcSetSceneBuildQuality(scene, quality);
  attachMesh(device, scene, mesh);
  rtcCommitScene(scene);
  return scene;
}

std::vector<Eigen::Vector3f> faceNormals(const MeshModel& mesh) {
  std::vector<Eigen::Vector3f> normals;
  normals.reserve(mesh.triangles.size());
  for (const auto& t : mesh.triangles)
    normals.push_back((mesh.vertices[t[1]] - mesh.vertices[t[0]])
                          .cross(mesh.vertices[t[2]] - mesh.vertices[t[0]])
                          .normalized());
  return normals;
}

TrainingObjects::TrainingObjects(const std::string& directory, const std::string& split)
    : device_(rtcNewDevice(nullptr)), by_class_(std::size(kTrainingClasses)) {
  const std::string index = directory + "/index.txt";
  std::ifstream in(index);
  if (!in) throw InputError(index + ": cannot be read; objects.py makes it");
  std::vector<IndexLine> lines;
  for (std::string text; std::getline(in, text);) {
    std::string of_split;
    IndexLine line = parse(text, index, &of_split);
    if (of_split == split || of_split == "both") lines.push_back(std::move(line));
  }
  std::vector<TrainingObject> objects(lines.size());
  std::vector<std::string> faults(lines.size());
  tbb::parallel_for(size_t{0}, lines.size(), [&](size_t i) {
    try {
      TrainingObject& object = objects[i];
      object.mesh = loadMesh(directory + "/" + lines[i].file, MapParameters());
      if (object.mesh.triangles.empty()) throw InputError(lines[i].file + ": no faces");
      standUp(lines[i], &object.mesh);
      object.label = lines[i].label;
      object.elevation = lines[i].elevation;
      object.size = lines[i].size;
      object.normals = faceNormals(object.mesh);
    } catch (const std::exception& e) {
      faults[i] = e.what();
    }
  });
  for (size_t i = 0; i < objects.size(); ++i) {
    if (!faults[i].empty()) {
      std::cerr << "left out: " << faults[i] << '\n';
      continue;
    }
    objects[i].scene = makeScene(device_, objects[i].mesh, RTC_BUILD_QUALITY_MEDIUM);
    by_class_[static_cast<size_t>(objects[i].label)].push_back(std::move(objects[i]));
  }
  std::string missing;
  for (size_t label = 0; label < by_class_.size(); ++label)
    if (by_class_[label].empty()) missing += std::string(" ") + kTrainingClasses[label];
  if (!missing.empty())
    throw InputError(index + ": split " + split + " has no object of these classes:" + missing);
}

TrainingObjects::~TrainingObjects() {
  for (auto& objects : by_class_)
    for (auto& object : objects) rtcReleaseScene(object.scene);
  if (device_) rtcReleaseDevice(device_);
}

}  // namespace edge_mcl
