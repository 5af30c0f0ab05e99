// edge-mcl detect: finds objects that are not in the map, and writes masks of them.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <set>

#include "apps/common_options.h"
#include "apps/number_range.h"
#include "apps/output_files.h"
#include "apps/progress_bar.h"
#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/image/picture_file.h"
#include "edge_mcl/core/recordings/sequence.h"
#include "edge_mcl/core/recordings/trajectory_evaluation.h"
#include "edge_mcl/detector/default_model.h"
#include "edge_mcl/detector/detection_overlay.h"
#include "edge_mcl/detector/mask_detector.h"
#include "edge_mcl/detector/recorded_flight_masks.h"

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

/// Lists the images of all inputs. @param camera is set for a sequence, whose images follow each
/// other in time. It stays empty for single images.
std::vector<InputImage> imagesOf(const DetectOptions& o, std::optional<CameraModel>* camera) {
  std::vector<InputImage> images;
  for (const std::string& input : o.inputs) {
    if (fs::exists(fs::path(input) / "rgb.txt")) {
      if (o.inputs.size() > 1) throw ParameterError("a sequence directory must be the only input");
      const Sequence sequence = readSequence(input);
      *camera = sequence.camera;
      for (const SequenceFrame& f : sequence.frames)
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
  if (images.empty()) throw InputError(o.inputs.front() + ": the folder has no images");
  return images;
}

std::string listOf(const DetectOptions& o) { return o.out + "/mask.txt"; }
std::string maskOf(const InputImage& image) { return "mask/" + image.name + ".png"; }
std::string overlayOf(const DetectOptions& o, const InputImage& image) {
  return o.overlay + "/" + image.name + ".png";
}

/// Checks the names of the output files. @throws ParameterError when a file would be written twice,
/// or would overwrite an input
void refuseOverwriting(const DetectOptions& o, const std::vector<InputImage>& images) {
  const auto placeOf = [](const std::string& file) {
    std::error_code unknown;
    const fs::path place = fs::weakly_canonical(fs::absolute(file), unknown);
    return unknown ? file : place.string();
  };
  std::set<std::string> read;
  for (const std::string& input : o.inputs)
    if (fs::exists(fs::path(input) / "rgb.txt"))  // a missing list is no input and may be written
      for (const char* list : {"/rgb.txt", "/mask.txt"})
        if (fs::exists(input + list)) read.insert(placeOf(input + list));
  for (const InputImage& image : images) {
    read.insert(placeOf(image.file));
    if (!image.true_mask_file.empty()) read.insert(placeOf(image.true_mask_file));
  }
  std::map<std::string, std::string> written;  // path of an output file -> its content
  const auto claim = [&](const std::string& file, const std::string& what) {
    const std::string place = placeOf(file);
    if (read.count(place) > 0)
      throw ParameterError(file + " is an input and would be overwritten; name another directory");
    const auto [before, is_new] = written.emplace(place, what);
    if (!is_new)
      throw ParameterError(before->second + " and " + what + " would both be written to " + file);
  };
  if (!o.out.empty()) claim(listOf(o), "the list");
  for (const InputImage& image : images) {
    if (!o.out.empty()) claim(o.out + "/" + maskOf(image), "the mask of " + image.file);
    if (!o.overlay.empty()) claim(overlayOf(o, image), "the picture of " + image.file);
  }
}

/// @param as_stored true: the orientation that a photograph stores is ignored, because the masks of
/// a sequence belong to the stored pixels.
cv::Mat readAnyImage(const std::string& file, bool as_stored) {
  cv::Mat image;
  try {
    image = cv::imread(
        file, as_stored ? cv::IMREAD_COLOR | cv::IMREAD_IGNORE_ORIENTATION : cv::IMREAD_COLOR);
  } catch (const cv::Exception& e) {
    throw InputError(file + ": cannot be decoded: " + e.err);
  }
  if (image.empty()) throw InputError(file + ": the file is missing or is not a readable image");
  return image;
}

cv::Mat readTrueMask(const std::string& file, const CameraModel& camera, const cv::Size& size) {
  cv::Mat mask = readMask(file, camera);
  if (mask.size() != size) throw InputError(file + ": the mask has another size than its image");
  return mask;
}

void print(const nlohmann::json& summary, const nlohmann::json& found, bool single_images) {
  if (single_images)
    for (const auto& entry : found) {
      std::printf("%s:", entry["image"].get<std::string>().c_str());
      for (const auto& d : entry["objects"])
        std::printf(" %s %.2f", d["class"].get<std::string>().c_str(), d["score"].get<double>());
      std::printf("%s\n", entry["objects"].empty() ? " no objects" : "");
    }
  std::printf("%s: %zu images, %zu runs of the network (median %.1f ms)",
              summary["model"].get<std::string>().c_str(), summary["images"].get<size_t>(),
              summary["network_runs"].get<size_t>(), summary["network_ms_median"].get<double>());
  if (summary.contains("tracking_ms_median"))
    std::printf(", tracking (median %.1f ms per image)",
                summary["tracking_ms_median"].get<double>());
  std::printf("; masked share of an image: median %.0f %%\n",
              100 * summary["covered_median"].get<double>());
  if (summary.contains("mask_iou_mean"))
    std::printf("overlap (intersection over union) with the masks of the sequence: mean %.3f\n",
                summary["mask_iou_mean"].get<double>());
}

DetectorParameters parametersOf(const DetectOptions& o) {
  DetectorParameters parameters;
  for (const std::string& assignment : o.assignments) {
    const auto equals = assignment.find('=');
    if (equals == std::string::npos)
      throw ParameterError("--set " + assignment + ": must have the form name=value");
    parameters.set(assignment.substr(0, equals), assignment.substr(equals + 1));
  }
  parameters.validate();
  return parameters;
}

/// Opens the list of masks. @throws InputError
std::ofstream openList(const DetectOptions& o, const std::string& model) {
  makeDirectory(o.out + "/mask");
  std::ofstream list(listOf(o));
  list << "# masks by edge-mcl detect, model " << model << ": timestamp filename" << std::endl;
  if (!list) throw InputError(listOf(o) + ": cannot be written");
  return list;
}

nlohmann::json jsonOf(const InputImage& input, const Detections& objects,
                      const std::vector<std::string>& classes) {
  nlohmann::json entry{{"image", input.name}, {"objects", nlohmann::json::array()}};
  for (const Detection& d : objects)
    entry["objects"].push_back({{"class", classes[static_cast<size_t>(d.class_id)]},
                                {"score", d.score},
                                {"track", d.track_id},
                                {"box", {d.box.x, d.box.y, d.box.width, d.box.height}}});
  return entry;
}

/// Figures of all images, for the summary.
struct DetectFigures {
  std::vector<double> network_ms, tracking_ms;
  std::vector<double> overlaps;  ///< intersection over union with the masks of the sequence
  std::vector<double> covered;   ///< masked share of the image
  size_t images = 0, unusable = 0;
};

nlohmann::json summaryOf(const DetectFigures& figures, const std::string& model) {
  const ErrorSummary network = summarize(figures.network_ms);
  nlohmann::json summary{{"model", model},
                         {"images", figures.images},
                         {"unusable_images", figures.unusable},
                         {"network_runs", figures.network_ms.size()},
                         {"network_ms_median", network.median},
                         {"network_ms_p90", network.p90},
                         {"covered_median", summarize(figures.covered).median}};
  if (!figures.tracking_ms.empty())
    summary["tracking_ms_median"] = summarize(figures.tracking_ms).median;
  if (!figures.overlaps.empty()) summary["mask_iou_mean"] = summarize(figures.overlaps).mean;
  return summary;
}

int run(const DetectOptions& o) {
  const DetectorParameters parameters = parametersOf(o);
  std::optional<CameraModel> camera;
  const std::vector<InputImage> images = imagesOf(o, &camera);
  const bool is_sequence = camera.has_value();
  if (!is_sequence && o.rate >= 0)
    throw ParameterError(
        "--rate needs a sequence directory: objects in single images cannot be tracked");
  refuseOverwriting(o, images);
  const DetectorModel model =
      DetectorModel::fromYamlFile(o.model.empty() ? defaultModelFile() : o.model);
  MaskDetector detector(model, parameters);
  if (!o.overlay.empty()) makeDirectory(o.overlay);
  std::ofstream list;
  if (!o.out.empty()) list = openList(o, model.name);
  RecordedFlightMasks flight(&detector, parameters, o.rate, o.delay);
  DetectFigures figures;
  figures.images = images.size();
  nlohmann::json found = nlohmann::json::array();
  ProgressBar bar(model.name, images.size());
  for (const InputImage& input : images) {
    bar.advance();
    cv::Mat image, mask, truth;
    try {
      image = readAnyImage(input.file, is_sequence);
      if (!input.true_mask_file.empty())
        truth = readTrueMask(input.true_mask_file, *camera, image.size());
    } catch (const InputError& e) {
      if (images.size() == 1) throw;
      bar.note(std::string("warning: ") + e.what());
      ++figures.unusable;
      if (image.empty()) continue;
    }
    Detections objects;
    if (is_sequence && o.rate >= 0) {
      flight.next(image, input.time);
      objects = flight.tracker().objects();
      mask = flight.tracker().mask();
      figures.tracking_ms.push_back(flight.trackingMs());
      if (flight.networkMs() > 0) figures.network_ms.push_back(flight.networkMs());
    } else {
      objects = detector.detect(image);
      mask = combinedMask(objects, image.size(), cvRound(parameters.dilation * image.cols / 320.0));
      figures.network_ms.push_back(detector.times().total());
    }
    figures.covered.push_back(static_cast<double>(cv::countNonZero(mask)) /
                              static_cast<double>(mask.total()));
    if (!truth.empty()) figures.overlaps.push_back(maskOverlap(mask, truth));
    found.push_back(jsonOf(input, objects, model.classes));
    if (list.is_open()) {
      writePicture(o.out + "/" + maskOf(input), mask);
      list << input.name << ' ' << maskOf(input) << std::endl;
      if (!list) throw InputError(listOf(o) + ": cannot be written (disk full?)");
    }
    if (!o.overlay.empty())
      writePicture(overlayOf(o, input), drawDetections(image, objects, model.classes));
  }
  const nlohmann::json summary = summaryOf(figures, model.name);
  if (o.json) {
    std::printf("%s\n", textOf({{"summary", summary}, {"images", found}}).c_str());
  } else {
    print(summary, found, !is_sequence);
  }
  return figures.unusable > 0 ? kExitIncomplete : kExitOk;
}

}  // namespace

void addDetect(CLI::App* app, Action* action) {
  auto o = std::make_shared<DetectOptions>();
  CLI::App* c = app->add_subcommand(
      "detect", "find people, sofas, chairs and computers in images, and write masks of them");
  c->add_option("input", o->inputs, "image files, folders of images, or one sequence directory")
      ->required();
  c->add_option(
      "--model", o->model,
      "YAML file that describes a network (see docs/detector.md); default: the network that "
      "comes with the package");
  c->add_option(
      "--out", o->out,
      "directory for mask.txt and the folder mask/, which `localize --masks` reads; default: "
      "no masks are written");
  c->add_option(
      "--overlay", o->overlay,
      "directory for pictures of the images with the found objects; default: no pictures");
  CLI::Option* rate =
      c->add_option("--rate", o->rate,
                    "runs of the network per second, in a sequence; 0 = one run for every image; "
                    "objects are tracked between the runs. Default: the network runs on every "
                    "image and nothing is tracked")
          ->check(numberFrom(0, 1e4));
  c->add_option(
       "--delay", o->delay,
       "time from an image to the use of the network's result, s; only with --rate; default 0")
      ->check(numberFrom(0, 60))
      ->needs(rate);
  c->add_option(
      "--set", o->assignments,
      "sets one parameter of the detector, e.g. --set dilation=5; can be given several times "
      "(see docs/parameters.md)");
  c->add_flag("--json", o->json, "print the found objects as JSON; default: as text");
  c->callback([o, action] { *action = [o] { return run(*o); }; });
}

}  // namespace edge_mcl
