/// Parameters of the detection. The facts about a network are in DetectorModel.
#pragma once

#include <string>
#include <vector>

#include "edge_mcl/core/base/parameter_range.h"

namespace edge_mcl {

/// Functions of parameter_struct.h apply.
struct DetectorParameters {
  std::string ignore_classes;
  double score_threshold = 0;
  double nms_threshold = 0.45;
  double min_area = 0.0005;
  int dilation = 3;
  double dilation_growth = 2;
  double half_life = 1.5;
  double min_confidence = 0.15;
  int max_misses = 2;
  double memory = 20;
  int points = 40;
  int threads = 0;
  std::string engine = "auto";

  template <class Visitor>
  void visit(Visitor&& v) {
    v("ignore_classes", ignore_classes, "", anyValue(),
      "classes that are masked, separated by commas; empty: those that the model calls movable");
    v("score_threshold", score_threshold, "", below(0, 1),
      "detections with a lower score are dropped; 0 = the model's own threshold");
    v("nms_threshold", nms_threshold, "", above(0, 1),
      "boxes whose overlap (intersection over union) is larger are one object");
    v("min_area", min_area, "", below(0, 1),
      "objects smaller than this share of the image are dropped");
    v("dilation", dilation, "px", from(0, 100),
      "growth of the mask in an image 320 pixels wide; it scales with the width");
    v("dilation_growth", dilation_growth, "px/s", from(0, 100),
      "further growth per second since the network last saw the object");
    v("half_life", half_life, "s", positive(),
      "time in which the confidence of an object that is not seen again halves");
    v("min_confidence", min_confidence, "", below(0, 1),
      "an object with a lower confidence is not masked");
    v("max_misses", max_misses, "", from(1, 1000),
      "an object ends when this many runs of the network in a row did not find it");
    v("memory", memory, "s", notNegative(), "time for which an object that ended keeps its number");
    v("points", points, "", from(4, 1000), "image corners that are followed per object");
    v("threads", threads, "", from(0, 1024),
      "threads of OpenCV in the whole process; 0 = all cores");
    v("engine", engine, "", oneOf("auto|opencv|onnxruntime"),
      "what runs the network; auto = OpenCV, and ONNX Runtime for an ONNX file that OpenCV cannot "
      "run");
  }

  /// @throws ParameterError that lists all faults
  void validate() const;
  /// Sets a parameter from text. @throws ParameterError for an unknown name (with the nearest known
  /// one) or a value of the wrong type
  void set(const std::string& name, const std::string& value);
};

}  // namespace edge_mcl
