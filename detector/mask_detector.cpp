#include "edge_mcl/detector/mask_detector.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <opencv2/dnn.hpp>
#include <opencv2/imgproc.hpp>
#include <sstream>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/detector/inference_engine.h"
#include "edge_mcl/detector/output_layouts.h"

namespace edge_mcl {

namespace {

class Stopwatch {
 public:
  double lap() {
    const auto now = std::chrono::steady_clock::now();
    const double ms = std::chrono::duration<double, std::milli>(now - last_).count();
    last_ = now;
    return ms;
  }

 private:
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

}  // namespace

MaskDetector::~MaskDetector() = default;

const char* MaskDetector::engine() const { return engine_->name(); }

MaskDetector::MaskDetector(const DetectorModel& model, const DetectorParameters& parameters)
    : model_(model),
      parameters_(parameters),
      ignored_(model.classes.size(), false),
      threshold_(parameters.score_threshold > 0 ? parameters.score_threshold
                                                : model.score_threshold) {
  parameters_.validate();
  std::vector<std::string> names = model.movable;
  if (!parameters.ignore_classes.empty()) {
    names.clear();
    std::istringstream list(parameters.ignore_classes);
    for (std::string name; std::getline(list, name, ',');) {
      const auto first = name.find_first_not_of(' '), last = name.find_last_not_of(' ');
      if (first != std::string::npos) names.push_back(name.substr(first, last - first + 1));
    }
  }
  if (names.empty())
    throw ParameterError("model " + model.name +
                         " has no movable class: name classes in ignore_classes");
  for (const std::string& name : names)  // several classes may have the same name
    for (auto c = static_cast<size_t>(model.classNumber(name)); c < ignored_.size(); ++c)
      if (model.classes[c] == name) ignored_[c] = true;
  std::error_code unused;
  for (const std::string& file : {model.file, model.config_file})
    if (!file.empty() && !std::filesystem::is_regular_file(file, unused))
      throw InputError("model " + model.name + ": " + file +
                       " is missing (scripts/fetch_models fetches public models)");
  engine_ = openEngine(model, parameters);
  // A first run reveals a wrong description now and not in flight. It also sets up the buffers.
  detect(cv::Mat(model.height, model.width, CV_8UC3, cv::Scalar::all(114)));
}

bool MaskDetector::isIgnored(int class_id) const {
  return class_id >= 0 && class_id < static_cast<int>(ignored_.size()) &&
         ignored_[static_cast<size_t>(class_id)];
}

cv::Mat MaskDetector::prepared(const cv::Mat& image, Placement* placement) const {
  if (image.empty() || (image.type() != CV_8UC3 && image.type() != CV_8UC1))
    throw InputError("detector: an image of 8 bits in colour or grey is needed");
  cv::Mat color = image;
  if (image.channels() == 1) cv::cvtColor(image, color, cv::COLOR_GRAY2BGR);
  const cv::Size size(model_.width, model_.height);
  cv::Mat fitted;
  const double sx = static_cast<double>(size.width) / image.cols,
               sy = static_cast<double>(size.height) / image.rows;
  if (model_.fit == InputFit::kStretch) {
    *placement = {sx, sy, 0, 0};
    cv::resize(color, fitted, size, 0, 0, sx < 1 ? cv::INTER_AREA : cv::INTER_LINEAR);
  } else {
    const double s = std::min(sx, sy);
    const cv::Size inner(std::max(1, std::min(size.width, cvRound(s * image.cols))),
                         std::max(1, std::min(size.height, cvRound(s * image.rows))));
    const bool centred = model_.fit == InputFit::kLetterboxCentred;
    const cv::Point corner(centred ? (size.width - inner.width) / 2 : 0,
                           centred ? (size.height - inner.height) / 2 : 0);
    *placement = {static_cast<double>(inner.width) / image.cols,
                  static_cast<double>(inner.height) / image.rows, static_cast<double>(corner.x),
                  static_cast<double>(corner.y)};
    fitted = cv::Mat(size, CV_8UC3, cv::Scalar::all(model_.padding));
    cv::Mat part = fitted(cv::Rect(corner, inner));
    cv::resize(color, part, inner, 0, 0, s < 1 ? cv::INTER_AREA : cv::INTER_LINEAR);
  }
  if (model_.rgb) cv::cvtColor(fitted, fitted, cv::COLOR_BGR2RGB);
  cv::Mat values;
  fitted.convertTo(values, CV_32FC3);
  cv::subtract(values, cv::Scalar(model_.mean[0], model_.mean[1], model_.mean[2]), values);
  cv::multiply(values, cv::Scalar(model_.scale[0], model_.scale[1], model_.scale[2]), values);
  return cv::dnn::blobFromImage(values);
}

std::vector<cv::Mat> MaskDetector::forward(const cv::Mat& input) {
  std::vector<cv::Mat> outputs = engine_->forward(input);
  // A NaN is never above a threshold, so without this check it would mean "nothing found".
  for (const cv::Mat& output : outputs)
    if (output.depth() == CV_32F && !cv::checkRange(output))
      throw InputError("model " + model_.name + ": its output is not finite");
  return outputs;
}

std::vector<cv::Mat> MaskDetector::rawOutputs(const cv::Mat& image) {
  Placement placement;
  return forward(prepared(image, &placement));
}

Detections MaskDetector::detect(const cv::Mat& image) {
  Stopwatch watch;
  Placement placement;
  const cv::Mat input = prepared(image, &placement);
  times_.preparation = watch.lap();
  const std::vector<cv::Mat> outputs = forward(input);
  times_.network = watch.lap();
  Detections found = model_.segments() ? segments(outputs.at(0), image.size())
                                       : boxes(outputs, image.size(), placement);
  times_.decoding = watch.lap();
  return found;
}

Detections MaskDetector::segments(const cv::Mat& scores, const cv::Size& size) const {
  const auto classes = static_cast<int>(model_.classes.size());
  if (scores.type() != CV_32F || scores.dims != 4 || scores.size[1] != classes) {
    std::string shape;
    for (int i = 0; i < scores.dims; ++i) shape += (i ? ", " : "") + std::to_string(scores.size[i]);
    throw InputError("model " + model_.name + ": its output is [" + shape +
                     "], but segmentation of " + std::to_string(classes) + " classes needs [1, " +
                     std::to_string(classes) + ", height, width]");
  }
  // Softmax at the network's resolution. The probabilities of all ignored classes are added, so
  // that a doubt between chair and sofa makes no hole in the mask.
  const int height = scores.size[2], width = scores.size[3];
  cv::Mat movable(height, width, CV_32F), best(height, width, CV_8U);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      float highest = -1e30f;
      for (int c = 0; c < classes; ++c)
        highest = std::max(highest, scores.ptr<float>(0, c)[y * width + x]);
      float sum = 0, ignored = 0, best_value = -1;
      int best_class = 0;
      for (int c = 0; c < classes; ++c) {
        const float p = std::exp(scores.ptr<float>(0, c)[y * width + x] - highest);
        sum += p;
        if (!ignored_[static_cast<size_t>(c)]) continue;
        ignored += p;
        if (p > best_value) {
          best_value = p;
          best_class = c;
        }
      }
      movable.at<float>(y, x) = ignored / sum;
      best.at<uint8_t>(y, x) = static_cast<uint8_t>(best_class);
    }
  cv::Mat probability, label;
  cv::resize(movable, probability, size, 0, 0, cv::INTER_LINEAR);
  cv::resize(best, label, size, 0, 0, cv::INTER_NEAREST);
  const cv::Mat mask = probability > threshold_;

  Detections found;
  cv::Mat component, statistics, centres;
  const int count = cv::connectedComponentsWithStats(mask, component, statistics, centres, 8);
  for (int k = 1; k < count; ++k) {
    if (statistics.at<int>(k, cv::CC_STAT_AREA) < parameters_.min_area * size.area()) continue;
    Detection d;
    const cv::Rect box(
        statistics.at<int>(k, cv::CC_STAT_LEFT), statistics.at<int>(k, cv::CC_STAT_TOP),
        statistics.at<int>(k, cv::CC_STAT_WIDTH), statistics.at<int>(k, cv::CC_STAT_HEIGHT));
    d.box = box;
    d.mask = component == k;
    std::vector<int> votes(static_cast<size_t>(classes), 0);
    for (int y = box.y; y < box.br().y; ++y)
      for (int x = box.x; x < box.br().x; ++x)
        if (d.mask.at<uint8_t>(y, x)) ++votes[label.at<uint8_t>(y, x)];
    d.class_id = static_cast<int>(std::max_element(votes.begin(), votes.end()) - votes.begin());
    d.score = static_cast<float>(cv::mean(probability, d.mask)[0]);
    found.push_back(std::move(d));
  }
  return found;
}

Detections MaskDetector::boxes(const std::vector<cv::Mat>& outputs, const cv::Size& size,
                               const Placement& placement) const {
  std::vector<NetworkBox> candidates = decodeBoxes(model_, outputs, static_cast<float>(threshold_));
  candidates.erase(std::remove_if(candidates.begin(), candidates.end(),
                                  [&](const NetworkBox& b) { return !isIgnored(b.class_id); }),
                   candidates.end());
  std::vector<cv::Rect2d> rectangles;
  std::vector<float> scores;
  for (const NetworkBox& b : candidates) {
    rectangles.emplace_back((b.box.x - placement.left) / placement.scale_x,
                            (b.box.y - placement.top) / placement.scale_y,
                            b.box.width / placement.scale_x, b.box.height / placement.scale_y);
    scores.push_back(b.score);
  }
  std::vector<int> kept;
  cv::dnn::NMSBoxes(rectangles, scores, static_cast<float>(threshold_),
                    static_cast<float>(parameters_.nms_threshold), kept);
  Detections found;
  for (const int i : kept) {
    const NetworkBox& candidate = candidates[static_cast<size_t>(i)];
    const cv::Rect2d whole = rectangles[static_cast<size_t>(i)];
    const cv::Rect2d seen = whole & cv::Rect2d(0, 0, size.width, size.height);
    if (seen.area() < parameters_.min_area * size.area()) continue;
    Detection d;
    d.class_id = candidate.class_id;
    d.score = candidate.score;
    d.box = seen;
    d.mask = cv::Mat::zeros(size, CV_8U);
    const cv::Rect pixels = cv::Rect(cv::Point(cvFloor(seen.x), cvFloor(seen.y)),
                                     cv::Point(cvCeil(seen.br().x), cvCeil(seen.br().y))) &
                            cv::Rect({}, size);
    if (candidate.mask.empty()) {
      d.mask(pixels) = 255;
    } else {
      const cv::Matx23f to_mask(
          static_cast<float>(candidate.mask.cols / whole.width), 0,
          static_cast<float>((pixels.x + 0.5 - whole.x) * candidate.mask.cols / whole.width - 0.5),
          0, static_cast<float>(candidate.mask.rows / whole.height),
          static_cast<float>((pixels.y + 0.5 - whole.y) * candidate.mask.rows / whole.height -
                             0.5));
      cv::Mat stretched;
      cv::warpAffine(candidate.mask, stretched, to_mask, pixels.size(),
                     cv::INTER_LINEAR | cv::WARP_INVERSE_MAP, cv::BORDER_REPLICATE);
      d.mask(pixels).setTo(255, stretched > 0.5);
    }
    found.push_back(std::move(d));
  }
  return found;
}

}  // namespace edge_mcl
