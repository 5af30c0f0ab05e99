#include "edge_mcl/mrpt_plugins/CEdgeMap.h"

#include <mrpt/config/CConfigFileBase.h>
#include <mrpt/opengl/CSetOfLines.h>
#include <mrpt/opengl/CSetOfObjects.h>
#include <mrpt/serialization/CArchive.h>

#include <algorithm>
#include <cctype>
#include <fstream>
#include <sstream>
#include <type_traits>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/base/parameter_struct.h"
#include "edge_mcl/localization/map_factory.h"
#include "edge_mcl/mrpt_plugins/mrpt_conversions.h"
#include "edge_mcl/mrpt_plugins/observation_input.h"

IMPLEMENTS_SERIALIZABLE(CEdgeMap, CMetricMap, edge_mcl)
MAP_DEFINITION_REGISTER("edge_mcl::CEdgeMap,CEdgeMap", edge_mcl::CEdgeMap)

namespace edge_mcl {

CEdgeMap::CEdgeMap(const std::string& model_file, const Parameters& params) {
  load(model_file, params);
}

void CEdgeMap::load(const std::string& model_file, const Parameters& params) {
  map_ = makeMap(model_file, params);
  model_file_ = model_file;
  cache_ = std::make_shared<ImageCache>();
}

void CEdgeMap::useCamera(const std::string& camera_file) {
  camera_.reset();
  if (!camera_file.empty()) camera_ = CameraModel::fromYamlFile(camera_file);
  camera_file_ = camera_file;
}

const LocalizationMap& CEdgeMap::localization() const {
  if (!map_) throw Error("edge map: no model is loaded");
  return *map_;
}

// ---- Definition in ini files

CEdgeMap::TMapDefinition::TMapDefinition() = default;

namespace {

/// Removes a comment after a value. MRPT's ini reader returns it as part of the value.
std::string withoutComment(std::string text) {
  text.resize(std::min(text.size(), text.find_first_of("#;")));
  while (!text.empty() && std::isspace(static_cast<unsigned char>(text.back()))) text.pop_back();
  return text;
}

}  // namespace

void CEdgeMap::TMapDefinition::loadFromConfigFile_map_specific(
    const mrpt::config::CConfigFileBase& source, const std::string& section_prefix) {
  const std::string section = section_prefix + "_creationOpts";
  std::string faults;
  std::vector<std::string> keys;
  source.getAllKeys(section, keys);
  // MRPT itself reads these keys, for every map.
  const std::vector<std::string> of_mrpt = {"enableSaveAs3DObject", "enableObservationLikelihood",
                                            "enableObservationInsertion"};
  for (const std::string& key : keys) {
    if (key == "model_file" || key == "camera_file" ||
        std::count(of_mrpt.begin(), of_mrpt.end(), key))
      continue;
    try {
      params.set(key, withoutComment(source.read_string(section, key, "")));
    } catch (const ParameterError& e) {
      faults += std::string(faults.empty() ? "" : "; ") + e.what();
    }
  }
  model_file = withoutComment(source.read_string(section, "model_file", ""));
  camera_file = withoutComment(source.read_string(section, "camera_file", ""));
  if (model_file.empty())
    faults += (faults.empty() ? "" : "; ") + ("[" + section + "] has no model_file");
  if (!faults.empty()) throw ParameterError("edge map: " + faults);
  params.validate();
}

void CEdgeMap::TMapDefinition::dumpToTextStream_map_specific(std::ostream& out) const {
  out << "model_file = " << model_file << "\ncamera_file = " << camera_file << "\n"
      << params.toYaml();
}

namespace {

/// A plain pointer in MRPT 2.5 (Debian 12), a shared one in MRPT 2.14 (Debian 13).
using CreatedMap = std::invoke_result_t<decltype(&CEdgeMap::internal_CreateFromMapDefinition),
                                        const mrpt::maps::TMetricMapInitializer&>;

}  // namespace

CreatedMap CEdgeMap::internal_CreateFromMapDefinition(
    const mrpt::maps::TMetricMapInitializer& definition) {
  const auto& d = dynamic_cast<const CEdgeMap::TMapDefinition&>(definition);
  auto map = std::make_unique<CEdgeMap>(d.model_file, d.params);
  map->useCamera(d.camera_file);
  return CreatedMap(map.release());
}

// ---- Serialization. The archive holds file names and parameters. The model itself stays on disk.

uint8_t CEdgeMap::serializeGetVersion() const { return 2; }

void CEdgeMap::serializeTo(mrpt::serialization::CArchive& out) const {
  out << model_file_ << camera_file_;
  const Parameters params = map_ ? map_->params() : Parameters();
  const auto values = describeParameters(params);
  out << static_cast<uint32_t>(values.size());
  for (const auto& v : values) out << v.name << v.value;
}

void CEdgeMap::serializeFrom(mrpt::serialization::CArchive& in, uint8_t version) {
  if (version > 2) MRPT_THROW_UNKNOWN_SERIALIZATION_VERSION(version);
  std::string file, camera_file;
  uint32_t count = 0;
  in >> file;
  if (version >= 1) in >> camera_file;
  in >> count;
  Parameters params;
  for (uint32_t i = 0; i < count; ++i) {
    std::string name, value;
    in >> name >> value;
    // Version 1 had a parameter for tests only.
    if (version >= 2 || name != "visibility.exact") params.set(name, value);
  }
  internal_clear();
  if (!file.empty()) load(file, params);
  useCamera(camera_file);
}

// ---- Observations

std::vector<CameraView> CEdgeMap::views(const mrpt::obs::CObservation& obs) const {
  std::vector<CameraView> result;
  const std::lock_guard<std::mutex> lock(cache_->mutex);
  if (localization().usesImages())
    if (const auto image = imageOf(obs, camera_ ? &*camera_ : nullptr)) {
      const uint64_t key = keyOf(obs, image->pixels, image->mask);
      if (!cache_->image || cache_->image_key != key) {
        cache_->image = map_->prepare(image->camera, image->pixels, image->mask, originOf(obs));
        cache_->image_key = key;
      }
      result.push_back({cache_->image, image->T_base_camera, 1, nullptr});
    }
  if (map_->usesDepth() && hasDepth(obs)) {
    const uint64_t key = depthKeyOf(obs);
    if (!cache_->depth || cache_->depth_key != key) {
      cache_->depth = map_->prepareDepth(depthOf(obs)->image);
      cache_->depth_key = key;
    }
    const auto sensor = static_cast<uint32_t>(std::hash<std::string>()(obs.sensorLabel));
    result.push_back({nullptr, depthMountingOf(obs), 1, cache_->depth, sensor});
  }
  return result;
}

std::vector<double> CEdgeMap::logLikelihoods(const mrpt::obs::CObservation& obs,
                                             const std::vector<Pose>& base_poses) const {
  std::vector<double> result(base_poses.size(), 0);
  const std::vector<PoseScore> scores = localization().evaluate(views(obs), base_poses);
  for (size_t i = 0; i < result.size(); ++i) result[i] = scores[i].log_likelihood;
  return result;
}

double CEdgeMap::internal_computeObservationLikelihood(
    const mrpt::obs::CObservation& obs, const mrpt::poses::CPose3D& taken_from) const {
  return logLikelihoods(obs, {toPose(taken_from)}).front();
}

bool CEdgeMap::internal_canComputeObservationLikelihood(const mrpt::obs::CObservation& obs) const {
  return map_ && ((map_->usesImages() && hasImage(obs)) || (map_->usesDepth() && hasDepth(obs)));
}

bool CEdgeMap::internal_insertObservation(const mrpt::obs::CObservation&,
                                          const std::optional<const mrpt::poses::CPose3D>&) {
  return false;  // the model is fixed: observations do not change it
}

void CEdgeMap::internal_clear() {
  map_.reset();
  model_file_.clear();
  camera_file_.clear();
  camera_.reset();
  cache_ = std::make_shared<ImageCache>();
}

// ---- Output

std::string CEdgeMap::asString() const {
  std::ostringstream out;
  out << "edge map of '" << model_file_ << "'";
  if (map_) out << ", " << map_->edges().lines.size() << " lines";
  return out.str();
}

void CEdgeMap::getVisualizationInto(mrpt::opengl::CSetOfObjects& out) const {
  if (!genericMapParams.enableSaveAs3DObject || !map_) return;
  auto lines = mrpt::opengl::CSetOfLines::Create();
  lines->setName("edge_mcl::CEdgeMap");
  lines->setColor_u8(0, 114, 178, 255);
  lines->setLineWidth(1.5f);
  for (const EdgeLine& line : map_->edges().lines)
    if (line.kind != EdgeKind::kContour)
      lines->appendLine(line.start.x(), line.start.y(), line.start.z(), line.end.x(), line.end.y(),
                        line.end.z());
  out.insert(lines);
}

void CEdgeMap::saveMetricMapRepresentationToFile(const std::string& prefix) const {
  const std::string file = prefix + "_edges.obj";
  std::ofstream out(file);
  out << "# feature lines of " << model_file_ << "\n";
  size_t index = 1;
  for (const EdgeLine& line : localization().edges().lines) {
    if (line.kind == EdgeKind::kContour) continue;  // it depends on the viewpoint
    out << "v " << line.start.transpose() << "\nv " << line.end.transpose() << "\nl " << index
        << " " << index + 1 << "\n";
    index += 2;
  }
  if (!out.flush()) throw InputError(file + ": cannot be written");
}

}  // namespace edge_mcl
