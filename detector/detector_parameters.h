/// What the user decides about detection; the network's own facts are in DetectorModel.
#pragma once

#include <string>
#include <vector>

namespace edge_mcl {

struct DetectorParameters {
  std::string ignore_classes;    ///< comma separated; empty: those the model calls movable
  double score_threshold = 0;    ///< 0 to 1; 0: the model's own
  double nms_threshold = 0.45;   ///< boxes that overlap by more are one
  double min_area = 0.0005;      ///< share of the image; smaller objects are left out
  int dilation = 3;              ///< px of an image 320 wide, in proportion for others
  double dilation_growth = 2;    ///< the same, per second since the network last saw the object
  double half_life = 1.5;        ///< s in which the confidence of what is not seen anew halves
  double min_confidence = 0.15;  ///< below it an object is no longer masked
  int max_misses = 2;            ///< runs of the network without it that end an object
  double memory = 20;            ///< s for which a lost object keeps its number
  int points = 40;               ///< corners that are followed per object
  int threads = 0;               ///< of all of OpenCV in this process; 0: all

  template <class Visitor>
  void visit(Visitor&& v) {
    v("ignore_classes", ignore_classes);
    v("score_threshold", score_threshold);
    v("nms_threshold", nms_threshold);
    v("min_area", min_area);
    v("dilation", dilation);
    v("dilation_growth", dilation_growth);
    v("half_life", half_life);
    v("min_confidence", min_confidence);
    v("max_misses", max_misses);
    v("memory", memory);
    v("points", points);
    v("threads", threads);
  }

  /// What is wrong with the values, one text each.
  std::vector<std::string> faults() const;
  /// @throws ParameterError listing all faults.
  void validate() const;
  /// From text. @throws ParameterError for an unknown name (naming the nearest) or a wrong value.
  void set(const std::string& name, const std::string& value);
};

}  // namespace edge_mcl
