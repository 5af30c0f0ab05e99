/// Runs a network on an input. OpenCV is the first engine, ONNX Runtime the second.
#pragma once

#include <memory>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "edge_mcl/detector/detector_model.h"
#include "edge_mcl/detector/detector_parameters.h"

namespace edge_mcl {

/// A network that is loaded. Not thread-safe.
class InferenceEngine {
 public:
  virtual ~InferenceEngine() = default;
  /// @param input CV_32F, [1, 3, height, width]. @return the outputs in the order of the model's
  /// `outputs`, CV_32F. @throws InputError when the network cannot be run
  virtual std::vector<cv::Mat> forward(const cv::Mat& input) = 0;
  virtual const char* name() const = 0;
};

/// Whether this build has ONNX Runtime. Debian 13 has it, Debian 12 has not.
bool hasOnnxRuntime();

/// Loads a network with the engine of the parameters. "auto" takes OpenCV, and ONNX Runtime for an
/// ONNX file that OpenCV cannot load or run. @throws InputError when no engine can
std::unique_ptr<InferenceEngine> openEngine(const DetectorModel& model,
                                            const DetectorParameters& parameters);

/// @throws InputError when OpenCV cannot load the network
std::unique_ptr<InferenceEngine> openWithOpenCv(const DetectorModel& model, int threads);
/// @throws InputError when ONNX Runtime cannot load the network, or is not there
std::unique_ptr<InferenceEngine> openWithOnnxRuntime(const DetectorModel& model, int threads);

}  // namespace edge_mcl
