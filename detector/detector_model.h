/// A network, described by a YAML file beside it: what goes in, what comes out.
#pragma once

#include <array>
#include <string>
#include <vector>

namespace edge_mcl {

/// How the network's output is laid out. N: boxes, C: classes; boxes are in pixels of the network's
/// input unless said otherwise.
enum class OutputLayout {
  kSegmentation,  ///< [1, C, h, w] scores before softmax; class 0 is background
  kSsd,           ///< [1, 1, N, 7]: image, class, score, left, top, right, bottom in shares
  kMaskRcnn,      ///< the same and a second output [N, C, h, w]: masks within the boxes
  kYolo,          ///< [1, N, 5 + C]: centre, size, objectness, class scores
  kYolox,         ///< the same, centre and size relative to the cells of several grids
  kYoloV8,        ///< [1, 4 + C, N]: centre, size, class scores
  kDarknet,       ///< per output [N, 5 + C]: as kYolo in shares, class scores times objectness
  kFastestDet,    ///< [1, 5 + C, h, w]: objectness, offset and size, class scores
};

/// How an image is brought to the network's size.
enum class InputFit {
  kStretch,           ///< each axis by itself
  kLetterbox,         ///< in proportion, at the top left, the rest filled
  kLetterboxCentred,  ///< in proportion, in the middle
};

struct DetectorModel {
  std::string name;         ///< of the YAML file, without its ending
  std::string file;         ///< weights or the whole network
  std::string config_file;  ///< empty: none needed
  int width = 320, height = 240;
  std::array<double, 3> mean{};            ///< subtracted first, in the network's colour order
  std::array<double, 3> scale{{1, 1, 1}};  ///< then multiplied
  bool rgb = false;                        ///< colour order; false: blue green red
  InputFit fit = InputFit::kStretch;
  double padding = 114;  ///< grey level of the letterbox's rest
  OutputLayout layout = OutputLayout::kSegmentation;
  std::vector<std::string> outputs;     ///< names; empty: all that nothing follows
  std::vector<int> strides{8, 16, 32};  ///< kYolox
  double score_threshold = 0.5;
  std::vector<std::string> classes;  ///< in the order of the network
  std::vector<std::string> movable;  ///< those that are ignored unless the user says else

  /// @throws InputError naming file, key and fault; unknown keys are faults, all are listed.
  static DetectorModel fromYamlFile(const std::string& file);

  /// Number of a class. @throws ParameterError naming the nearest.
  int classNumber(const std::string& class_name) const;
  bool segments() const { return layout == OutputLayout::kSegmentation; }
};

}  // namespace edge_mcl
