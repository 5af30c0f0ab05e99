// edge-mcl where: the likely poses of single photographs, without a start and without motion.
#include <CLI/CLI.hpp>
#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "apps/common_options.h"
#include "apps/number_range.h"
#include "apps/output_files.h"
#include "apps/progress_bar.h"
#include "apps/recordings/recording_options.h"
#include "edge_mcl/core/base/angles.h"
#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/drawing/overlay.h"
#include "edge_mcl/core/image/picture_file.h"
#include "edge_mcl/core/recordings/sequence.h"
#include "edge_mcl/localization/search/ranked_poses.h"

namespace edge_mcl {

namespace {

struct WhereOptions {
  std::vector<std::string> photos;
  std::string model, camera, mask, up, near, pictures;
  size_t answers = 5;
  double sure = 0.8;
  bool json = false;
  ParameterOptions parameters;
};

/// @throws ParameterError when the text is not x,y,z,radius.
std::optional<SearchRegion> parseNear(const std::string& text) {
  if (text.empty()) return std::nullopt;
  SearchRegion region;
  char rest = 0;
  Eigen::Vector3d& c = region.centre;
  if (std::sscanf(text.c_str(), "%lf,%lf,%lf,%lf%c", &c.x(), &c.y(), &c.z(), &region.radius,
                  &rest) != 4 ||
      !c.allFinite() || !(region.radius > 0) || !std::isfinite(region.radius))
    throw ParameterError("--near " + text + ": must be x,y,z,radius in metres");
  return region;
}

/// Where a camera looks, in degrees.
struct ViewAngles {
  double heading, pitch, roll;
};

/// @param R_map_camera of an optical frame.
ViewAngles anglesOf(const Eigen::Matrix3d& R_map_camera) {
  const Eigen::Vector3d ahead = R_map_camera.col(2), right = R_map_camera.col(0);
  const Eigen::Vector3d level = ahead.cross(Eigen::Vector3d::UnitZ());
  ViewAngles angles{};
  angles.heading = std::atan2(ahead.y(), ahead.x()) / kDegree;
  angles.pitch = std::asin(std::clamp(ahead.z(), -1.0, 1.0)) / kDegree;
  // Straight up or down there is no level direction, and the roll is part of the heading.
  if (level.norm() > 1e-6)
    angles.roll = std::atan2(-right.z(), right.dot(level.normalized())) / kDegree;
  return angles;
}

/// Answers for photographs of one camera in one map.
class PhotoFinder {
 public:
  /// Prepares the places of the map, with a progress bar.
  PhotoFinder(const WhereOptions& o)
      : options_(o),
        params_(o.parameters.load()),
        camera_(CameraModel::fromYamlFile(o.camera)),
        map_(o.model, params_) {
    for (const std::string& warning : map_.mesh().report.warnings)
      std::fprintf(stderr, "warning: %s: %s\n", o.model.c_str(), warning.c_str());
    constexpr double kUpSigma = 2 * kDegree;  // of a phone or an inertial unit
    if (const auto up = parseUp(o.up)) up_ = UpReading{*up, kUpSigma};
    region_ = parseNear(o.near);
    if (params_.map.absolute_poses) origin_ = map_.mesh().origin;
    if (region_) region_->centre -= origin_;
    if (!o.mask.empty()) mask_ = readMask(o.mask, camera_);
    constexpr size_t kSteps = 100;
    ProgressBar bar("preparing places", kSteps);
    std::mutex mutex;
    size_t shown = 0;
    map_.preparedPlaces([&](double share) {
      const std::lock_guard<std::mutex> lock(mutex);
      for (; static_cast<double>(shown) < share * kSteps; ++shown) bar.advance();
    });
    search_ = std::make_unique<PoseSearch>(map_);
  }

  /// @return whether one answer is sure.
  bool answer(const std::string& photo, nlohmann::json* list) {
    const cv::Mat image = readImage(photo, camera_);
    RandomSource random(params_.filter.seed);  // an answer does not depend on other photographs
    const auto begin = std::chrono::steady_clock::now();
    CameraView view;
    view.image = map_.prepare(camera_, image, mask_, photo);
    const RankedPoses ranked =
        rankPoses(search_.get(), {view}, up_, region_, options_.answers, &random);
    const double ms =
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
    nlohmann::json j = {
        {"photo", photo}, {"ms", ms}, {"none", ranked.none}, {"poses", nlohmann::json::array()}};
    for (const RankedPose& pose : ranked.poses) j["poses"].push_back(jsonOf(pose));
    const bool is_sure = !ranked.poses.empty() && ranked.poses.front().probability >= options_.sure;
    j["sure"] = is_sure;
    const std::string doubt = doubtOf(*view.image, ranked);
    if (!doubt.empty()) j["doubt"] = doubt;
    if (!options_.json) print(j);
    list->push_back(std::move(j));
    if (!options_.pictures.empty()) draw(photo, *view.image, ranked);
    return is_sure;
  }

 private:
  /// Why there can be no good answer; empty: nothing is known.
  std::string doubtOf(const PreparedImage& image, const RankedPoses& ranked) const {
    constexpr double kMostlyMasked = 0.8;
    if (!mask_.empty() &&
        cv::countNonZero(mask_) > kMostlyMasked * static_cast<double>(mask_.total()))
      return "the mask hides most of the photograph";
    if (image.edges.edgeCount() < static_cast<size_t>(params_.tracking.min_edge_pixels))
      return "the photograph shows hardly any edges";
    if (ranked.poses.empty() && region_)
      return "no place in the sphere of --near is free; the model may lie elsewhere";
    return {};
  }

  nlohmann::json jsonOf(const RankedPose& pose) const {
    const Eigen::Vector3d p = pose.found.pose.translation() + origin_;
    const Eigen::Quaterniond q(pose.found.pose.linear());
    const ViewAngles angles = anglesOf(pose.found.pose.linear());
    return {{"probability", pose.probability},
            {"position", {p.x(), p.y(), p.z()}},
            {"quaternion_xyzw", {q.x(), q.y(), q.z(), q.w()}},
            {"heading_deg", angles.heading},
            {"pitch_deg", angles.pitch},
            {"roll_deg", angles.roll},
            {"score", pose.found.log_likelihood},
            {"match_ratio", pose.found.match_ratio},
            {"contour_share", pose.found.contour_share}};
  }

  static void print(const nlohmann::json& j) {
    std::printf("%s (%.0f ms)\n", j["photo"].get<std::string>().c_str(), j["ms"].get<double>());
    for (const nlohmann::json& pose : j["poses"])
      std::printf("  %3.0f %%  at (%.2f, %.2f, %.2f) m, heading %.0f, pitch %.0f, roll %.0f deg\n",
                  100 * pose["probability"].get<double>(), pose["position"][0].get<double>(),
                  pose["position"][1].get<double>(), pose["position"][2].get<double>(),
                  pose["heading_deg"].get<double>(), pose["pitch_deg"].get<double>(),
                  pose["roll_deg"].get<double>());
    std::printf("  %3.0f %%  somewhere else\n%s", 100 * j["none"].get<double>(),
                j["sure"].get<bool>() ? "" : "  ambiguous: no answer is sure\n");
    if (j.contains("doubt")) std::printf("  %s\n", j["doubt"].get<std::string>().c_str());
  }

  void draw(const std::string& photo, const PreparedImage& image, const RankedPoses& ranked) {
    std::string stem = std::filesystem::path(photo).stem().string();
    // Photographs of two folders may have the same name.
    const int times = ++drawn_[stem];
    if (times > 1) stem += "-" + std::to_string(times);
    for (size_t i = 0; i < ranked.poses.size(); ++i)
      writePicture(options_.pictures + "/" + stem + "_" + std::to_string(i + 1) + ".png",
                   drawOverlay(map_, image, ranked.poses[i].found.pose));
  }

  const WhereOptions& options_;
  Parameters params_;
  CameraModel camera_;
  LocalizationMap map_;
  std::map<std::string, int> drawn_;
  std::optional<UpReading> up_;
  std::optional<SearchRegion> region_;
  Eigen::Vector3d origin_ = Eigen::Vector3d::Zero();
  cv::Mat mask_;
  std::unique_ptr<PoseSearch> search_;
};

int run(const WhereOptions& o) {
  if (!o.pictures.empty()) makeDirectory(o.pictures);
  PhotoFinder finder(o);
  nlohmann::json answers = nlohmann::json::array();
  bool all_sure = true;
  size_t unreadable = 0;
  for (const std::string& photo : o.photos) {
    try {
      all_sure &= finder.answer(photo, &answers);
    } catch (const InputError& e) {
      // The other photographs still get their answers.
      std::fprintf(stderr, "edge-mcl: %s\n", e.what());
      answers.push_back({{"photo", photo}, {"error", e.what()}});
      ++unreadable;
    }
  }
  if (o.json) std::printf("%s\n", textOf(answers).c_str());
  if (unreadable == o.photos.size()) return kExitInput;
  return all_sure && unreadable == 0 ? kExitOk : kExitIncomplete;
}

}  // namespace

void addWhere(CLI::App* app, Action* action) {
  auto o = std::make_shared<WhereOptions>();
  CLI::App* c = app->add_subcommand(
      "where",
      "tell where single photographs were taken: likely poses of the camera with probabilities. "
      "Exit code 4: ambiguous, no answer is sure");
  c->add_option("photos", o->photos, "image files of one camera")->required();
  c->add_option("--model", o->model, "model of the building")->required();
  c->add_option("--camera", o->camera, "file with the calibration (YAML of ROS camera_calibration)")
      ->required();
  c->add_option("--mask", o->mask,
                "image whose pixels that are not black are ignored, the same for all photographs; "
                "default: no mask");
  c->add_option("--up", o->up,
                "the upward direction x,y,z in the axes of the camera (x right, y down, z ahead), "
                "good to 2 degrees, e.g. 0,-1,0 for a level camera; default: not known");
  c->add_option("--near", o->near,
                "x,y,z,radius in metres: only poses in this sphere are tried; default: the whole "
                "model");
  c->add_option("--answers", o->answers, "largest number of poses; default 5")
      ->check(CLI::Range(1, 100));
  c->add_option("--sure", o->sure,
                "probability of the first pose above which it is sure; default 0.8")
      ->check(numberFrom(0, 1));
  c->add_option("--pictures", o->pictures,
                "directory for pictures: the model at each pose laid over the photograph");
  c->add_flag("--json", o->json, "print the answers as JSON");
  o->parameters.addTo(c);
  c->callback([o, action] { *action = [o] { return run(*o); }; });
}

}  // namespace edge_mcl
