#include "edge_mcl/core/base/error.h"
#include "edge_mcl/detector/inference_engine.h"

#ifdef EDGE_MCL_HAS_ONNXRUNTIME
#include <onnxruntime_cxx_api.h>
#endif

namespace edge_mcl {

#ifdef EDGE_MCL_HAS_ONNXRUNTIME

namespace {

class OnnxRuntimeEngine : public InferenceEngine {
 public:
  OnnxRuntimeEngine(const DetectorModel& model, int threads) : origin_("model " + model.name) {
    try {
      Ort::SessionOptions options;
      options.SetIntraOpNumThreads(threads);  // 0: all cores
      options.SetGraphOptimizationLevel(GraphOptimizationLevel::ORT_ENABLE_ALL);
      session_ = Ort::Session(env_, model.file.c_str(), options);
      readNames(model);
    } catch (const Ort::Exception& e) {
      throw InputError(origin_ + ": " + model.file + " cannot be loaded: " + e.what());
    }
  }

  std::vector<cv::Mat> forward(const cv::Mat& input) override {
    try {
      return run(input);
    } catch (const Ort::Exception& e) {
      throw InputError(origin_ + ": cannot be run: " + e.what());
    }
  }

  const char* name() const override { return "onnxruntime"; }

 private:
  void readNames(const DetectorModel& model) {
    const Ort::AllocatorWithDefaultOptions allocator;
    if (session_.GetInputCount() != 1)
      throw InputError(origin_ + ": the network has " + std::to_string(session_.GetInputCount()) +
                       " inputs; one image is needed");
    input_ = session_.GetInputNameAllocated(0, allocator).get();
    const auto type = session_.GetInputTypeInfo(0).GetTensorTypeAndShapeInfo().GetElementType();
    is_half_ = type == ONNX_TENSOR_ELEMENT_DATA_TYPE_FLOAT16;
    if (!is_half_ && type != ONNX_TENSOR_ELEMENT_DATA_TYPE_FLOAT)
      throw InputError(origin_ +
                       ": the input of the network is no image of floating point numbers");
    outputs_ = model.outputs;
    for (size_t i = 0; model.outputs.empty() && i < session_.GetOutputCount(); ++i)
      outputs_.emplace_back(session_.GetOutputNameAllocated(i, allocator).get());
  }

  std::vector<cv::Mat> run(const cv::Mat& input) {
    cv::Mat values = input;
    if (is_half_) input.convertTo(values, CV_16F);
    const std::vector<int64_t> shape(values.size.p, values.size.p + values.dims);
    const Ort::MemoryInfo memory = Ort::MemoryInfo::CreateCpu(OrtArenaAllocator, OrtMemTypeDefault);
    const Ort::Value tensor = Ort::Value::CreateTensor(
        memory, values.data, values.total() * values.elemSize(), shape.data(), shape.size(),
        is_half_ ? ONNX_TENSOR_ELEMENT_DATA_TYPE_FLOAT16 : ONNX_TENSOR_ELEMENT_DATA_TYPE_FLOAT);
    const char* const input_name = input_.c_str();
    std::vector<const char*> names;
    names.reserve(outputs_.size());
    for (const std::string& output : outputs_) names.push_back(output.c_str());
    std::vector<Ort::Value> results =
        session_.Run(Ort::RunOptions(nullptr), &input_name, &tensor, 1, names.data(), names.size());
    std::vector<cv::Mat> found;
    found.reserve(results.size());
    for (Ort::Value& result : results) found.push_back(matOf(&result));
    return found;
  }

  cv::Mat matOf(Ort::Value* result) const {
    const auto info = result->GetTensorTypeAndShapeInfo();
    const auto type = info.GetElementType();
    const bool is_half = type == ONNX_TENSOR_ELEMENT_DATA_TYPE_FLOAT16;
    if (!is_half && type != ONNX_TENSOR_ELEMENT_DATA_TYPE_FLOAT)
      throw InputError(origin_ + ": an output of the network holds no floating point numbers");
    std::vector<int> sizes;
    for (const int64_t size : info.GetShape()) sizes.push_back(static_cast<int>(size));
    const cv::Mat values(sizes, is_half ? CV_16F : CV_32F, result->GetTensorMutableRawData());
    cv::Mat copy;  // the tensor ends with the run
    values.convertTo(copy, CV_32F);
    return copy;
  }

  std::string origin_;
  Ort::Env env_{ORT_LOGGING_LEVEL_ERROR, "edge_mcl"};
  Ort::Session session_{nullptr};
  std::string input_;
  bool is_half_ = false;  // the input has half precision
  std::vector<std::string> outputs_;
};

}  // namespace

bool hasOnnxRuntime() { return true; }

std::unique_ptr<InferenceEngine> openWithOnnxRuntime(const DetectorModel& model, int threads) {
  return std::make_unique<OnnxRuntimeEngine>(model, threads);
}

#else

bool hasOnnxRuntime() { return false; }

std::unique_ptr<InferenceEngine> openWithOnnxRuntime(const DetectorModel& model, int /*threads*/) {
  throw InputError(
      "model " + model.name +
      ": engine=onnxruntime, but this build has no ONNX Runtime (libonnxruntime-dev of "
      "Debian 13)");
}

#endif

}  // namespace edge_mcl
