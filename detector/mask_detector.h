/// Runs a detection or segmentation network on images and returns objects with masks.
#pragma once

#include <memory>
#include <opencv2/core.hpp>

#include "edge_mcl/detector/detections.h"
#include "edge_mcl/detector/detector_model.h"
#include "edge_mcl/detector/detector_parameters.h"

namespace edge_mcl {

class InferenceEngine;

/// Times of the stages for one image, ms.
struct DetectorTimes {
  double preparation = 0, network = 0, decoding = 0;
  double total() const { return preparation + network + decoding; }
};

/// Finds the objects of the ignored classes in an image. Not thread-safe.
class MaskDetector {
 public:
  /// Loads the network and runs it once on a grey image.
  /// @throws InputError when a file is missing or broken, or the output does not fit the model's
  /// description; ParameterError for classes that the model does not have, or when no class is
  /// ignored.
  MaskDetector(const DetectorModel& model, const DetectorParameters& parameters);
  ~MaskDetector();

  /// Finds objects of the ignored classes. The mask of an object has the pixels that the network
  /// gives; without pixels it is the whole box. @param image CV_8UC3, blue green red, or CV_8U.
  /// @throws InputError for an empty image, an image of another type, or an output of the network
  /// that is not finite.
  Detections detect(const cv::Mat& image);

  /// Times of the last detect().
  const DetectorTimes& times() const { return times_; }
  const DetectorModel& model() const { return model_; }
  /// What runs the network: "opencv" or "onnxruntime".
  const char* engine() const;
  /// Returns the raw outputs of the network for an image, in the order of the model's `outputs`.
  std::vector<cv::Mat> rawOutputs(const cv::Mat& image);

 private:
  struct Placement {  // of the image in the network's input
    double scale_x, scale_y, left, top;
  };
  cv::Mat prepared(const cv::Mat& image, Placement* placement) const;
  std::vector<cv::Mat> forward(const cv::Mat& input);
  Detections segments(const cv::Mat& scores, const cv::Size& size) const;
  Detections boxes(const std::vector<cv::Mat>& outputs, const cv::Size& size,
                   const Placement& placement) const;
  bool isIgnored(int class_id) const;

  std::unique_ptr<InferenceEngine> engine_;
  DetectorModel model_;
  DetectorParameters parameters_;
  std::vector<bool> ignored_;  // one entry for every class
  double threshold_;
  DetectorTimes times_;
};

}  // namespace edge_mcl
