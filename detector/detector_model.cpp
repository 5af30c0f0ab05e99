#include "edge_mcl/detector/detector_model.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <map>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/base/parameter_struct.h"
#include "edge_mcl/core/base/parameters.h"
#include "edge_mcl/core/base/yaml_file.h"

namespace edge_mcl {

namespace {

const std::map<std::string, OutputLayout> kLayouts = {{"segmentation", OutputLayout::kSegmentation},
                                                      {"ssd", OutputLayout::kSsd},
                                                      {"mask_rcnn", OutputLayout::kMaskRcnn},
                                                      {"yolo", OutputLayout::kYolo},
                                                      {"yolox", OutputLayout::kYolox},
                                                      {"yolov8", OutputLayout::kYoloV8},
                                                      {"yolov8_seg", OutputLayout::kYoloV8Seg},
                                                      {"end_to_end", OutputLayout::kEndToEnd},
                                                      {"darknet", OutputLayout::kDarknet},
                                                      {"fastestdet", OutputLayout::kFastestDet}};
const std::map<std::string, InputFit> kFits = {{"stretch", InputFit::kStretch},
                                               {"letterbox", InputFit::kLetterbox},
                                               {"letterbox_centred", InputFit::kLetterboxCentred}};

template <class Value>
std::string namesOf(const std::map<std::string, Value>& values) {
  std::string all;
  for (const auto& [name, value] : values) all += (all.empty() ? "" : ", ") + name;
  return all;
}

/// Reads the keys of a YAML map and collects all faults.
class Keys {
 public:
  using Reader = std::function<void(const YAML::Node&)>;
  template <class T>
  Keys& value(const std::string& key, T* target) {
    readers_[key] = [target](const YAML::Node& n) { *target = n.as<T>(); };
    return *this;
  }
  /// Adds a key whose value is one number for all three channels or a list of three numbers.
  Keys& triple(const std::string& key, std::array<double, 3>* target) {
    readers_[key] = [target](const YAML::Node& n) {
      if (n.IsSequence())
        *target = n.as<std::array<double, 3>>();
      else
        target->fill(n.as<double>());
    };
    return *this;
  }
  template <class T>
  Keys& choice(const std::string& key, const std::map<std::string, T>& values, T* target) {
    readers_[key] = [this, key, &values, target](const YAML::Node& n) {
      const auto found = values.find(n.as<std::string>());
      if (found == values.end())
        faults_.push_back(key + " must be one of " + namesOf(values));
      else
        *target = found->second;
    };
    return *this;
  }
  void read(const YAML::Node& root) {
    std::vector<std::string> known;
    for (const auto& [key, reader] : readers_) known.push_back(key);
    for (const auto& entry : root) {
      if (!entry.first.IsScalar()) {
        faults_.emplace_back("a key is not a plain name");
        continue;
      }
      const auto key = entry.first.as<std::string>();
      const auto found = readers_.find(key);
      if (found == readers_.end()) {
        faults_.push_back("unknown key '" + key + "' (nearest: '" + nearestName(key, known) + "')");
        continue;
      }
      try {
        found->second(entry.second);
      } catch (const YAML::Exception&) {
        faults_.push_back("the value of '" + key + "' cannot be read");
      }
    }
  }
  std::vector<std::string>& faults() { return faults_; }

 private:
  std::map<std::string, Reader> readers_;
  std::vector<std::string> faults_;
};

}  // namespace

DetectorModel DetectorModel::fromYamlFile(const std::string& file) {
  const YAML::Node root = loadYamlFile(file);
  if (!root.IsMap()) throw InputError(file + ": keys and values expected");
  DetectorModel m;
  std::string order = "bgr", note;
  Keys keys;
  keys.value("file", &m.file).value("config", &m.config_file).value("width", &m.width);
  keys.value("height", &m.height).triple("mean", &m.mean).triple("scale", &m.scale);
  keys.value("colors", &order).choice("fit", kFits, &m.fit).value("padding", &m.padding);
  keys.choice("layout", kLayouts, &m.layout).value("outputs", &m.outputs);
  keys.value("strides", &m.strides).value("score_threshold", &m.score_threshold);
  keys.value("classes", &m.classes).value("movable", &m.movable);
  keys.value("origin", &note).value("license", &note);
  keys.read(root);
  std::vector<std::string>& faults = keys.faults();
  const auto require = [&](bool good, const char* text) {
    if (!good) faults.emplace_back(text);
  };
  require(!m.file.empty(), "'file' is missing");
  require(m.width >= 8 && m.width <= 8192 && m.height >= 8 && m.height <= 8192,
          "width and height must be 8 to 8192");
  require(order == "bgr" || order == "rgb", "colors must be bgr or rgb");
  const auto finite = [](double v) { return std::isfinite(v); };
  require(std::all_of(m.mean.begin(), m.mean.end(), finite), "mean must be finite");
  require(std::all_of(m.scale.begin(), m.scale.end(),
                      [](double v) { return std::isfinite(v) && v != 0; }),
          "scale must be finite and not 0");
  require(std::isfinite(m.padding), "padding must be finite");
  require(m.score_threshold > 0 && m.score_threshold < 1, "score_threshold must be in (0, 1)");
  require(!m.classes.empty(), "'classes' is missing");
  require(std::all_of(m.strides.begin(), m.strides.end(), [](int s) { return s > 0; }),
          "strides must be positive");
  require(m.layout != OutputLayout::kSegmentation || m.fit == InputFit::kStretch,
          "segmentation needs fit: stretch");
  for (const std::string& name : m.movable)
    if (std::find(m.classes.begin(), m.classes.end(), name) == m.classes.end())
      faults.push_back("movable: '" + name + "' is not among the classes");
  if (!faults.empty()) {
    std::string all;
    for (const std::string& fault : faults) all += (all.empty() ? "" : "; ") + fault;
    throw InputError(file + ": " + all);
  }
  m.rgb = order == "rgb";
  const std::filesystem::path path(file);
  m.name = path.stem().string();
  const auto beside = [&](std::string* other) {
    if (!other->empty()) *other = (path.parent_path() / *other).string();
  };
  beside(&m.file);
  beside(&m.config_file);
  return m;
}

int DetectorModel::classNumber(const std::string& class_name) const {
  const auto found = std::find(classes.begin(), classes.end(), class_name);
  if (found == classes.end())
    throw ParameterError("model " + name + " has no class '" + class_name + "' (nearest: '" +
                         nearestName(class_name, classes) + "')");
  return static_cast<int>(found - classes.begin());
}

}  // namespace edge_mcl
