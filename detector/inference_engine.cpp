#include "edge_mcl/detector/inference_engine.h"

#include <array>
#include <opencv2/dnn.hpp>

#include "edge_mcl/core/base/error.h"

namespace edge_mcl {

namespace {

class OpenCvEngine : public InferenceEngine {
 public:
  OpenCvEngine(const DetectorModel& model, int threads) : origin_("model " + model.name) {
    try {
      net_ = cv::dnn::readNet(model.file, model.config_file);
    } catch (const std::exception& e) {
      const std::string why = e.what();
      if (why.find("FLOAT16") != std::string::npos)
        throw InputError(origin_ + ": " + model.file +
                         " has half precision, which OpenCV does not read; export it with full "
                         "precision (half=False)");
      throw InputError(origin_ + ": " + model.file + " cannot be loaded: " + why);
    }
    if (net_.empty()) throw InputError(origin_ + ": " + model.file + " holds no network");
    // OpenCV has one number of threads for the whole process, so it is set before the flight.
    if (threads > 0) cv::setNumThreads(threads);
    net_.setPreferableBackend(cv::dnn::DNN_BACKEND_OPENCV);
    net_.setPreferableTarget(cv::dnn::DNN_TARGET_CPU);
    outputs_.assign(model.outputs.begin(), model.outputs.end());
    if (outputs_.empty()) outputs_ = net_.getUnconnectedOutLayersNames();
  }

  std::vector<cv::Mat> forward(const cv::Mat& input) override {
    std::vector<cv::Mat> outputs;
    try {
      net_.setInput(input);
      net_.forward(outputs, outputs_);
    } catch (const cv::Exception& e) {
      throw InputError(origin_ + ": cannot be run: " + e.what());
    }
    return outputs;
  }

  const char* name() const override { return "opencv"; }

 private:
  std::string origin_;
  cv::dnn::Net net_;
  std::vector<cv::String> outputs_;
};

bool isOnnx(const std::string& file) {
  return file.size() > 5 && file.compare(file.size() - 5, 5, ".onnx") == 0;
}

}  // namespace

std::unique_ptr<InferenceEngine> openWithOpenCv(const DetectorModel& model, int threads) {
  return std::make_unique<OpenCvEngine>(model, threads);
}

std::unique_ptr<InferenceEngine> openEngine(const DetectorModel& model,
                                            const DetectorParameters& parameters) {
  if (parameters.engine == "onnxruntime") return openWithOnnxRuntime(model, parameters.threads);
  if (parameters.engine == "opencv" || !hasOnnxRuntime() || !isOnnx(model.file))
    return openWithOpenCv(model, parameters.threads);
  std::string why;
  try {
    std::unique_ptr<InferenceEngine> engine = openWithOpenCv(model, parameters.threads);
    // Some networks are loaded, but their layers do not fit one another when they run.
    const std::array<int, 4> shape{1, 3, model.height, model.width};
    engine->forward(cv::Mat(4, shape.data(), CV_32F, cv::Scalar(0)));
    return engine;
  } catch (const InputError& e) {
    why = e.what();
  }
  try {
    return openWithOnnxRuntime(model, parameters.threads);
  } catch (const InputError& e) {
    throw InputError(why + "; nor with ONNX Runtime: " + e.what());
  }
}

}  // namespace edge_mcl
