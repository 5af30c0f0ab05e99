/// Reads the YAML description of a network: its file, its input and its output.
#pragma once

#include <array>
#include <string>
#include <vector>

namespace edge_mcl {

/// Layout of the network's output. N: number of boxes, C: number of classes. Boxes are in pixels of
/// the network's input, or in shares of its width and height where the layout says so. The boxes of
/// kYolo, kYoloV8, kYoloV8Seg and kEndToEnd may be in shares: no box of pixels is that small.
enum class OutputLayout {
  kSegmentation,  ///< [1, C, h, w]: scores before softmax; class 0 is the background
  kSsd,           ///< [1, 1, N, 7]: image, class, score; left, top, right, bottom in shares
  kMaskRcnn,      ///< as kSsd, and a second output [N, C, h, w]: masks within the boxes
  kYolo,          ///< [1, N, 5 + C]: centre, size, objectness, class scores
  kYolox,         ///< as kYolo, with centre and size relative to the cells of several grids
  kYoloV8,        ///< [1, 4 + C, N]: centre, size, class scores
  kYoloV8Seg,     ///< [1, 4 + C + M, N]: as kYoloV8, and M weights of mask prototypes; a second
                  ///< output [1, M, h, w]: the prototypes
  kEndToEnd,      ///< [1, N, 6]: left, top, right, bottom, score, class
  kDarknet,       ///< every output [N, 5 + C]: centre and size in shares, objectness, class scores;
                  ///< the class scores already contain the objectness
  kFastestDet,    ///< [1, 5 + C, h, w]: objectness, offset, size, class scores
};

/// How an image is fitted into the network's input.
enum class InputFit {
  kStretch,           ///< width and height are scaled separately
  kLetterbox,         ///< in proportion, at the top left, the rest is filled
  kLetterboxCentred,  ///< in proportion, in the middle, the rest is filled
};

/// Description of a network.
struct DetectorModel {
  std::string name;                        ///< name of the YAML file without its ending
  std::string file;                        ///< weights or the whole network
  std::string config_file;                 ///< second file of some formats; empty: not needed
  int width = 320, height = 240;           ///< of the network's input, pixels
  std::array<double, 3> mean{};            ///< is subtracted first, in the network's colour order
  std::array<double, 3> scale{{1, 1, 1}};  ///< is multiplied afterwards
  bool rgb = false;                        ///< colour order: red green blue; false: blue green red
  InputFit fit = InputFit::kStretch;
  double padding = 114;  ///< grey level that fills the rest of a letterbox
  OutputLayout layout = OutputLayout::kSegmentation;
  std::vector<std::string> outputs;     ///< names of outputs; empty: all unconnected outputs
  std::vector<int> strides{8, 16, 32};  ///< kYolox only: pixels per grid cell
  double score_threshold = 0.5;
  std::vector<std::string> classes;  ///< names in the order of the network
  std::vector<std::string> movable;  ///< classes that are ignored unless the user names others

  /// Reads a description. @throws InputError with file, key and fault. It lists all faults; an
  /// unknown key is a fault.
  static DetectorModel fromYamlFile(const std::string& file);

  /// Returns the number of a class. @throws ParameterError for an unknown name; it names the
  /// nearest class.
  int classNumber(const std::string& class_name) const;
  /// Whether the network segments pixels. Other networks find boxes.
  bool segments() const { return layout == OutputLayout::kSegmentation; }
};

}  // namespace edge_mcl
