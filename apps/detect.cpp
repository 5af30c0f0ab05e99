// edge-mcl detect: images in, masks of what is not in the map out.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "common_options.h"
#include "edge_mcl/core/error.h"
#include "edge_mcl/core/picture_file.h"
#include "edge_mcl/core/sequence.h"
#include "edge_mcl/core/trajectory_evaluation.h"
#include "edge_mcl/detector/default_model.h"
#include "edge_mcl/detector/detection_overlay.h"
#include "edge_mcl/detector/mask_detector.h"
#include "edge_mcl/detector/recorded_flight_masks.h"
#include "output_files.h"
#include "progress_bar.h"

namespace edge_mcl {

namespace {

namespace fs = std::filesystem;

struct DetectOptions {
  std::vector<std::string> inputs, assignments;
  std::string model, out, overlay;
  double rate = -1, delay = 0;
  bool json = false;
};

struct InputImage {
  double time = 0;
  std::string name, file, true_mask_file;
};

bool isImageFile(const fs::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension == ".png" || extension == ".jpg" || extension == ".jpeg" ||
         extension == ".bmp" || extension == ".pgm" || extension == ".ppm";
}

/// Images of a sequence, of a folder, or single files. @param is_sequence they follow each other.
std::vector<InputImage> imagesOf(const DetectOptions& o, bool* is_sequence) {
  std::vector<InputImage> images;
  *is_sequence = false;
  for (const std::string& input : o.inputs) {
    if (fs::exists(fs::path(input) / "rgb.txt")) {
      if (o.inputs.size() > 1) throw ParameterError("one sequence at a time");
      *is_sequence = true;
      for (const SequenceFrame& f : readSequence(input).frames)
        images.push_back({f.time, f.time_text, f.image_file, f.mask_file});
    } else if (fs::is_directory(input)) {
      std::vector<fs::path> files;
      for (const auto& entry : fs::directory_iterator(input))
        if (isImageFile(entry.path())) files.push_back(entry.path());
      std::sort(files.begin(), files.end());
      for (const fs::path& file : files)
        images.push_back({0, file.stem().string(), file.string(), ""});
    } else {
      images.push_back({0, fs::path(input).stem().string(), input, ""});
    }
  }
  if (images.empty()) throw InputError(o.inputs.front() + ": no images there");
  return images;
}

/// @param as_stored a sequence's masks lie on its pixels, however a photograph says it was held.
cv::Mat readAnyImage(const std::string& file, bool as_stored) {
  cv::Mat image = cv::imread(
      file, as_stored ? cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION : cv::IMREAD_COLOR);
  if (image.empty()) throw InputError(file + ": missing or not a readable image");
  return image;
}

int run(const DetectOptions& o) {
  DetectorParameters parameters;
  for (const std::string& assignment : o.assignments) {
    const auto equals = assignment.find('=');
    if (equals == std::string::npos)
      throw ParameterError("--set " + assignment + ": name=value expected");
    parameters.set(assignment.substr(0, equals), assignment.substr(equals + 1));
  }
  parameters.validate();
  bool is_sequence = false;
  const std::vector<InputImage> images = imagesOf(o, &is_sequence);
  if (!is_sequence && o.rate >= 0)
    throw ParameterError("--rate belongs to a sequence: single images cannot be tracked");
  const DetectorModel model =
      DetectorModel::fromYamlFile(o.model.empty() ? defaultModelFile() : o.model);
  MaskDetector detector(model, parameters);
  if (!o.overlay.empty()) makeDirectory(o.overlay);
  std::ofstream list;
  if (!o.out.empty()) {
    makeDirectory(o.out + "/mask");
    list.open(o.out + "/mask.txt");
    list << "# masks by edge-mcl detect, model " << model.name << ": timestamp filename\n";
  }
  RecordedFlightMasks flight(&detector, parameters, o.rate, o.delay);
  std::vector<double> network_ms, tracking_ms, overlaps, covered;
  nlohmann::json found = nlohmann::json::array();
  ProgressBar bar(model.name, images.size());
  for (const InputImage& input : images) {
    const cv::Mat image = readAnyImage(input.file, is_sequence);
    Detections objects;
    cv::Mat mask;
    if (is_sequence && o.rate >= 0) {
      flight.next(image, input.time);
      objects = flight.tracker().objects();
      mask = flight.tracker().mask();
      tracking_ms.push_back(flight.trackingMs());
      if (flight.networkMs() > 0) network_ms.push_back(flight.networkMs());
    } else {
      objects = detector.detect(image);
      mask = combinedMask(objects, image.size(), cvRound(parameters.dilation * image.cols / 320.0));
      network_ms.push_back(detector.times().total());
    }
    covered.push_back(static_cast<double>(cv::countNonZero(mask)) /
                      static_cast<double>(mask.total()));
    if (!input.true_mask_file.empty()) {
      cv::Mat truth = cv::imread(input.true_mask_file, cv::IMREAD_GRAYSCALE) > 0;
      if (truth.size() == mask.size()) overlaps.push_back(maskOverlap(mask, truth));
    }
    nlohmann::json entry{{"image", input.name}, {"objects", nlohmann::json::array()}};
    for (const Detection& d : objects)
      entry["objects"].push_back({{"class", model.classes[static_cast<size_t>(d.class_id)]},
                                  {"score", d.score},
                                  {"track", d.track_id},
                                  {"box", {d.box.x, d.box.y, d.box.width, d.box.height}}});
    found.push_back(std::move(entry));
    if (list.is_open()) {
      const std::string name = "mask/" + input.name + ".png";
      writePicture(o.out + "/" + name, mask);
      list << input.name << ' ' << name << std::endl;
    }
    if (!o.overlay.empty())
      writePicture(o.overlay + "/" + input.name + ".png",
                   drawDetections(image, objects, model.classes));
    bar.advance();
  }
  const ErrorSummary network = summarize(network_ms);
  nlohmann::json summary{{"model", model.name},
                         {"images", images.size()},
                         {"network_runs", network_ms.size()},
                         {"network_ms_median", network.median},
                         {"network_ms_p90", network.p90},
                         {"covered_median", summarize(covered).median}};
  if (!tracking_ms.empty()) summary["tracking_ms_median"] = summarize(tracking_ms).median;
  if (!overlaps.empty()) {
    double sum = 0;
    for (const double v : overlaps) sum += v;
    summary["mask_iou_mean"] = sum / static_cast<double>(overlaps.size());
  }
  if (o.json) {
    std::printf("%s\n", nlohmann::json{{"summary", summary}, {"images", found}}.dump(1).c_str());
    return kExitOk;
  }
  if (!is_sequence)
    for (const auto& entry : found) {
      std::printf("%s:", entry["image"].get<std::string>().c_str());
      for (const auto& d : entry["objects"])
        std::printf(" %s %.2f", d["class"].get<std::string>().c_str(), d["score"].get<double>());
      std::printf("%s\n", entry["objects"].empty() ? " nothing" : "");
    }
  std::printf("%s: %zu images, %zu runs of the network, %.1f ms each", model.name.c_str(),
              images.size(), network_ms.size(), network.median);
  if (!tracking_ms.empty())
    std::printf(", tracking %.1f ms per image", summary["tracking_ms_median"].get<double>());
  std::printf("; %.0f %% of an image masked (median)\n",
              100 * summary["covered_median"].get<double>());
  if (!overlaps.empty())
    std::printf("overlap with the sequence's own masks: %.3f (mean over images)\n",
                summary["mask_iou_mean"].get<double>());
  return kExitOk;
}

}  // namespace

void addDetect(CLI::App* app, Action* action) {
  auto o = std::make_shared<DetectOptions>();
  CLI::App* c = app->add_subcommand("detect", "mask what moves: people, sofas, chairs, computers");
  c->add_option("input", o->inputs, "images, a folder of them, or a sequence directory")
      ->required();
  c->add_option("--model", o->model,
                "YAML description of a network; default: the one that comes with the package");
  c->add_option("--out", o->out, "directory for mask.txt and mask/, for `localize --masks`");
  c->add_option("--overlay", o->overlay, "directory for pictures of what was found");
  c->add_option("--rate", o->rate,
                "of a sequence: runs of the network per second, 0 = every image; objects are "
                "tracked in between. Without it every image is looked at by itself")
      ->check(CLI::Range(0.0, 1e4));
  c->add_option("--delay", o->delay, "s after which the network's result is there, with --rate")
      ->check(CLI::Range(0.0, 60.0));
  c->add_option("--set", o->assignments,
                "one parameter of the detector, e.g. dilation=5 (repeatable)");
  c->add_flag("--json", o->json, "print what was found as JSON");
  c->callback([o, action] { *action = [o] { return run(*o); }; });
}

}  // namespace edge_mcl
