#include "edge_mcl/detector/output_layouts.h"

#include <algorithm>
#include <cmath>

#include "edge_mcl/core/base/error.h"

namespace edge_mcl {

namespace {

std::string shapeOf(const cv::Mat& m) {
  std::string text = "[";
  for (int i = 0; i < m.dims; ++i) text += (i ? ", " : "") + std::to_string(m.size[i]);
  return text + "]";
}

/// The layout that an output of this shape has with the model's classes; empty: none is known.
std::string layoutOfShape(const DetectorModel& model, const cv::Mat& output) {
  if (output.dims != 3) return "";
  const int classes = static_cast<int>(model.classes.size());
  const int rows = output.size[1], columns = output.size[2];
  if (columns == 6 && rows > 6) return "end_to_end";
  if (rows == 4 + classes) return "yolov8";
  if (columns == 5 + classes) return "yolo or yolox";
  if (rows > 4 + classes && rows < columns) return "yolov8_seg";
  return "";
}

[[noreturn]] void wrongShape(const DetectorModel& model, const cv::Mat& output,
                             const std::string& expected) {
  const std::string other = layoutOfShape(model, output);
  throw InputError("model " + model.name + ": its output is " + shapeOf(output) +
                   ", but its layout and " + std::to_string(model.classes.size()) +
                   " classes need " + expected +
                   (other.empty() ? "" : "; the shape is that of layout: " + other));
}

/// Returns the output as a matrix with `columns` columns, without a copy. @throws InputError
cv::Mat asRows(const DetectorModel& model, const cv::Mat& output, int columns) {
  if (output.type() != CV_32F || output.dims < 2 || output.size[output.dims - 1] != columns)
    wrongShape(model, output, "rows of " + std::to_string(columns));
  const auto rows = static_cast<int>(output.total() / static_cast<size_t>(columns));
  return {rows, columns, CV_32F, const_cast<float*>(output.ptr<float>())};
}

int bestOf(const float* scores, size_t count) {
  return static_cast<int>(std::max_element(scores, scores + count) - scores);
}

cv::Rect2f aroundCentre(float x, float y, float width, float height) {
  return {x - 0.5f * width, y - 0.5f * height, width, height};
}

float sigmoid(float v) { return 1 / (1 + std::exp(-v)); }

bool usable(const NetworkBox& b, float threshold) {
  return b.score >= threshold && std::isfinite(b.score) && std::isfinite(b.box.x) &&
         std::isfinite(b.box.y) && std::isfinite(b.box.width) && std::isfinite(b.box.height) &&
         b.box.width > 0 && b.box.height > 0;
}

class Decoder {
 public:
  Decoder(const DetectorModel& model, float threshold) : model_(model), threshold_(threshold) {}

  void ssd(const cv::Mat& output, const cv::Mat* masks) {
    const cv::Mat rows = asRows(model_, output, 7);
    if (masks && (masks->dims != 4 || masks->size[0] < rows.rows ||
                  masks->size[1] > static_cast<int>(model_.classes.size())))
      wrongShape(model_, *masks, "masks by box and class");
    for (int i = 0; i < rows.rows; ++i) {
      const float* r = rows.ptr<float>(i);
      NetworkBox b;
      b.class_id = cvRound(r[1]);
      b.score = r[2];
      b.box = {toX(r[3]), toY(r[4]), toX(r[5] - r[3]), toY(r[6] - r[4])};
      if (!(b.score >= threshold_)) continue;
      if (b.class_id < 0 || b.class_id >= classCount())
        throw InputError("model " + model_.name + ": class " + std::to_string(b.class_id) +
                         ", but " + std::to_string(classCount()) + " classes are named");
      if (masks && b.class_id < masks->size[1])
        b.mask = cv::Mat(masks->size[2], masks->size[3], CV_32F,
                         const_cast<float*>(masks->ptr<float>(i, b.class_id)))
                     .clone();
      keep(std::move(b));
    }
  }

  void yolo(const cv::Mat& output) {
    const cv::Mat rows = asRows(model_, output, 5 + classCount());
    for (int i = 0; i < rows.rows; ++i) {
      const float* r = rows.ptr<float>(i);
      keep(ofClasses(r + 5, r[4], aroundCentre(r[0], r[1], r[2], r[3])));
    }
  }

  void darknet(const cv::Mat& output) {
    const cv::Mat rows = asRows(model_, output, 5 + classCount());
    for (int i = 0; i < rows.rows; ++i) {
      const float* r = rows.ptr<float>(i);
      keep(ofClasses(r + 5, 1, aroundCentre(toX(r[0]), toY(r[1]), toX(r[2]), toY(r[3]))));
    }
  }

  void yolox(const cv::Mat& output) {
    const cv::Mat rows = asRows(model_, output, 5 + classCount());
    int expected = 0;
    for (const int stride : model_.strides)
      expected += (model_.width / stride) * (model_.height / stride);
    if (rows.rows != expected)
      wrongShape(model_, output, std::to_string(expected) + " cells for its strides");
    int i = 0;
    for (const int stride : model_.strides)
      for (int y = 0; y < model_.height / stride; ++y)
        for (int x = 0; x < model_.width / stride; ++x) {
          const float* r = rows.ptr<float>(i++);
          const auto s = static_cast<float>(stride);
          keep(ofClasses(
              r + 5, r[4],
              aroundCentre((r[0] + static_cast<float>(x)) * s, (r[1] + static_cast<float>(y)) * s,
                           std::exp(r[2]) * s, std::exp(r[3]) * s)));
        }
  }

  void yoloV8(const cv::Mat& output) {
    if (output.type() != CV_32F || output.dims != 3 || output.size[1] != 4 + classCount())
      wrongShape(model_, output, "[1, " + std::to_string(4 + classCount()) + ", boxes]");
    cv::Mat rows;
    cv::transpose(
        cv::Mat(output.size[1], output.size[2], CV_32F, const_cast<float*>(output.ptr<float>())),
        rows);
    for (int i = 0; i < rows.rows; ++i) {
      const float* r = rows.ptr<float>(i);
      keep(ofClasses(r + 4, 1, aroundCentre(r[0], r[1], r[2], r[3])));
    }
  }

  /// @param prototypes of the masks
  void yoloV8Seg(const cv::Mat& output, const cv::Mat& prototypes) {
    if (prototypes.type() != CV_32F || prototypes.dims != 4)
      wrongShape(model_, prototypes, "prototypes [1, M, h, w] as the second output");
    const int count = prototypes.size[1], channels = 4 + classCount() + count;
    if (output.type() != CV_32F || output.dims != 3 || output.size[1] != channels)
      wrongShape(model_, output, "[1, " + std::to_string(channels) + ", boxes]");
    cv::Mat rows;
    cv::transpose(
        cv::Mat(output.size[1], output.size[2], CV_32F, const_cast<float*>(output.ptr<float>())),
        rows);
    std::vector<cv::Mat> weights;  // of the prototypes, one row for each box that is kept
    for (int i = 0; i < rows.rows; ++i) {
      const float* r = rows.ptr<float>(i);
      if (keep(ofClasses(r + 4, 1, aroundCentre(r[0], r[1], r[2], r[3]))))
        weights.push_back(rows(cv::Rect(4 + classCount(), i, count, 1)));
    }
    toPixels();
    for (size_t i = 0; i < boxes.size(); ++i)
      boxes[i].mask = maskOf(boxes[i], weights[i], prototypes);
  }

  void endToEnd(const cv::Mat& output) {
    const cv::Mat rows = asRows(model_, output, 6);
    for (int i = 0; i < rows.rows; ++i) {
      const float* r = rows.ptr<float>(i);
      NetworkBox b;
      b.box = {r[0], r[1], r[2] - r[0], r[3] - r[1]};
      b.score = r[4];
      b.class_id = cvRound(r[5]);
      if (!usable(b, threshold_)) continue;
      if (b.class_id < 0 || b.class_id >= classCount())
        throw InputError("model " + model_.name + ": class " + std::to_string(b.class_id) +
                         ", but " + std::to_string(classCount()) + " classes are named");
      keep(std::move(b));
    }
  }

  /// Brings boxes in shares of the input to pixels. When all of them end within the first two
  /// pixels, they are shares.
  void toPixels() {
    constexpr float kLargestShare = 2;  // boxes may reach over the border of the image
    if (std::any_of(boxes.begin(), boxes.end(), [](const NetworkBox& b) {
          return b.box.br().x > kLargestShare || b.box.br().y > kLargestShare;
        }))
      return;
    for (NetworkBox& b : boxes)
      b.box = {toX(b.box.x), toY(b.box.y), toX(b.box.width), toY(b.box.height)};
  }

  /// Score: objectness to the power 0.6 times class score to the power 0.4. Centre: tanh, relative
  /// to the grid cell. Size: sigmoid, share of the input. Source: the detect function of
  /// FastestDet.
  void fastestDet(const cv::Mat& output) {
    if (output.type() != CV_32F || output.dims != 4 || output.size[1] != 5 + classCount())
      wrongShape(model_, output, "[1, " + std::to_string(5 + classCount()) + ", rows, columns]");
    const int height = output.size[2], width = output.size[3];
    std::vector<float> scores(model_.classes.size());
    const auto at = [&](int channel, int y, int x) {
      return output.ptr<float>(0, channel)[y * width + x];
    };
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        for (int c = 0; c < classCount(); ++c) scores[static_cast<size_t>(c)] = at(5 + c, y, x);
        NetworkBox b;
        b.class_id = bestOf(scores.data(), scores.size());
        b.score = std::pow(std::max(0.0f, at(0, y, x)), 0.6f) *
                  std::pow(std::max(0.0f, scores[static_cast<size_t>(b.class_id)]), 0.4f);
        if (b.score < threshold_) continue;
        b.box = aroundCentre(
            toX((std::tanh(at(1, y, x)) + static_cast<float>(x)) / static_cast<float>(width)),
            toY((std::tanh(at(2, y, x)) + static_cast<float>(y)) / static_cast<float>(height)),
            toX(sigmoid(at(3, y, x))), toY(sigmoid(at(4, y, x))));
        keep(std::move(b));
      }
  }

  std::vector<NetworkBox> boxes;

 private:
  int classCount() const { return static_cast<int>(model_.classes.size()); }
  float toX(float share) const { return share * static_cast<float>(model_.width); }
  float toY(float share) const { return share * static_cast<float>(model_.height); }
  NetworkBox ofClasses(const float* scores, float objectness, const cv::Rect2f& box) const {
    NetworkBox b;
    b.class_id = bestOf(scores, model_.classes.size());
    b.score = objectness * scores[b.class_id];
    b.box = box;
    return b;
  }
  /// The mask of a box: the weighted sum of the prototypes, cut out at the box. Source: the
  /// process_mask function of YOLACT (Bolya et al. 2019, section 3.1), which YOLOv8-seg uses.
  cv::Mat maskOf(const NetworkBox& b, const cv::Mat& weights, const cv::Mat& prototypes) const {
    const int height = prototypes.size[2], width = prototypes.size[3];
    const float to_x = static_cast<float>(width) / static_cast<float>(model_.width);
    const float to_y = static_cast<float>(height) / static_cast<float>(model_.height);
    const int left = std::max(0, cvFloor(b.box.x * to_x)),
              top = std::max(0, cvFloor(b.box.y * to_y));
    const int right = std::min(width, cvCeil(b.box.br().x * to_x));
    const int bottom = std::min(height, cvCeil(b.box.br().y * to_y));
    if (right <= left || bottom <= top) return {};
    cv::Mat sum = cv::Mat::zeros(bottom - top, right - left, CV_32F);
    for (int m = 0; m < weights.cols; ++m) {
      const cv::Mat plane(height, width, CV_32F, const_cast<float*>(prototypes.ptr<float>(0, m)));
      sum += weights.at<float>(0, m) * plane(cv::Range(top, bottom), cv::Range(left, right));
    }
    for (auto it = sum.begin<float>(); it != sum.end<float>(); ++it) *it = sigmoid(*it);
    return sum;
  }
  /// @return whether the box is kept
  bool keep(NetworkBox box) {
    if (!usable(box, threshold_)) return false;
    boxes.push_back(std::move(box));
    return true;
  }
  const DetectorModel& model_;
  float threshold_;
};

}  // namespace

std::vector<NetworkBox> decodeBoxes(const DetectorModel& model, const std::vector<cv::Mat>& outputs,
                                    float threshold) {
  Decoder decoder(model, threshold);
  const bool has_masks =
      model.layout == OutputLayout::kMaskRcnn || model.layout == OutputLayout::kYoloV8Seg;
  const size_t wanted = has_masks ? 2 : 1;
  if (outputs.size() < wanted)
    throw InputError("model " + model.name + ": " + std::to_string(wanted) +
                     " outputs are needed, " + std::to_string(outputs.size()) + " found");
  if (model.layout == OutputLayout::kMaskRcnn) {
    decoder.ssd(outputs[0], &outputs[1]);
    return std::move(decoder.boxes);
  }
  if (model.layout == OutputLayout::kYoloV8Seg) {
    const bool is_first = outputs[0].dims == 3;  // exporters differ in the order
    decoder.yoloV8Seg(outputs[is_first ? 0 : 1], outputs[is_first ? 1 : 0]);
    return std::move(decoder.boxes);
  }
  for (const cv::Mat& output : outputs) switch (model.layout) {
      case OutputLayout::kSsd:
        decoder.ssd(output, nullptr);
        break;
      case OutputLayout::kYolo:
        decoder.yolo(output);
        break;
      case OutputLayout::kYolox:
        decoder.yolox(output);
        break;
      case OutputLayout::kYoloV8:
        decoder.yoloV8(output);
        break;
      case OutputLayout::kEndToEnd:
        decoder.endToEnd(output);
        break;
      case OutputLayout::kDarknet:
        decoder.darknet(output);
        break;
      case OutputLayout::kFastestDet:
        decoder.fastestDet(output);
        break;
      case OutputLayout::kSegmentation:
      case OutputLayout::kMaskRcnn:
      case OutputLayout::kYoloV8Seg:
        break;
    }
  if (model.layout == OutputLayout::kYolo || model.layout == OutputLayout::kYoloV8 ||
      model.layout == OutputLayout::kEndToEnd)
    decoder.toPixels();
  return std::move(decoder.boxes);
}

}  // namespace edge_mcl
