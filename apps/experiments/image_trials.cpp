// edge-mcl image-trials: asks for the place of single images whose pose is known, and compares.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "apps/common_options.h"
#include "apps/experiments/right_pose.h"
#include "apps/number_range.h"
#include "apps/output_files.h"
#include "apps/progress_bar.h"
#include "edge_mcl/core/base/angles.h"
#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/recordings/sequence.h"
#include "edge_mcl/localization/search/ranked_poses.h"
#include "edge_mcl/sim/trial_flight.h"

namespace edge_mcl {

namespace {

struct ImageTrialOptions {
  std::string source, model, out;
  int count = 0, every = 0;  // 0: not given
  uint64_t first_seed = 1;
  double imu_sigma_deg = 1;
  size_t answers = 5;
  bool no_gravity = false, no_mask = false, json = false;
  ParameterOptions parameters;
};

struct TestImage {
  CameraModel camera;
  cv::Mat image, mask;
  Pose T_map_camera = Pose::Identity();
};

/// Asks, and keeps the answers.
class ImageTrials {
 public:
  ImageTrials(const ImageTrialOptions& o, const std::string& model)
      : options_(o), map_(model, o.parameters.load()), random_(o.first_seed) {
    map_.preparedPlaces();
    search_ = std::make_unique<PoseSearch>(map_);
  }

  void ask(const TestImage& test) {
    CameraView view;
    std::optional<UpReading> up;
    if (!options_.no_gravity) {
      up.emplace();
      up->sigma = options_.imu_sigma_deg * kDegree;
      const Eigen::Vector3d error =
          up->sigma * Eigen::Vector3d(random_.normal(), random_.normal(), random_.normal());
      up->up_base =
          expSo3(error) * (test.T_map_camera.linear().transpose() * Eigen::Vector3d::UnitZ());
    }
    const auto begin = std::chrono::steady_clock::now();
    view.image =
        map_.prepare(test.camera, test.image, options_.no_mask ? cv::Mat() : test.mask, "image");
    const RankedPoses ranked =
        rankPoses(search_.get(), {view}, up, std::nullopt, options_.answers, &random_);
    const double ms =
        std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count();
    nlohmann::json j = {{"ms", ms}, {"none", ranked.none}, {"poses", nlohmann::json::array()}};
    const double lines =
        map_.evaluate({{view.image, Pose::Identity(), 1, nullptr}}, {test.T_map_camera})
            .front()
            .line_count;
    j["lines_in_view"] = lines;
    // What the right pose would score tells a pose that was not tried from one that loses.
    j["score_of_truth"] = search_
                              ->sharpen(search_->prepare({view}), test.T_map_camera,
                                        search_->looseAround(test.T_map_camera, up))
                              .log_likelihood;
    int rank = 0;
    for (const RankedPose& pose : ranked.poses) {
      const bool right = isNear(pose.found.pose, test.T_map_camera, kRightPose);
      if (right && rank == 0) rank = static_cast<int>(j["poses"].size()) + 1;
      const Twist error = logSe3(pose.found.pose.inverse() * test.T_map_camera);
      j["poses"].push_back({{"probability", pose.probability},
                            {"score", pose.found.log_likelihood},
                            {"evidence", pose.found.evidence},
                            {"match_ratio", pose.found.match_ratio},
                            {"contour_share", pose.found.contour_share},
                            {"right", right},
                            {"error_m", error.head<3>().norm()},
                            {"error_deg", error.tail<3>().norm() / kDegree}});
    }
    j["rank"] = rank;
    images_.push_back(std::move(j));
    ms_.push_back(ms);
    first_ += rank == 1 ? 1 : 0;
    constexpr double kSure = 0.8;  // the default of edge-mcl where
    if (!ranked.poses.empty() && ranked.poses.front().probability >= kSure) {
      ++sure_;
      sure_wrong_ += rank == 1 ? 0 : 1;
    }
    among_ += rank > 0 ? 1 : 0;
  }

  nlohmann::json summary() const {
    std::vector<double> ms = ms_;
    std::sort(ms.begin(), ms.end());
    const auto quantile = [&](size_t percent) {
      return ms.empty() ? 0 : ms[std::min(ms.size() - 1, ms.size() * percent / 100)];
    };
    const auto share = [&](int count) {
      return images_.empty() ? 0 : count / static_cast<double>(images_.size());
    };
    return {{"source", options_.source},
            {"images", images_.size()},
            {"first_right", share(first_)},
            {"among_answers", share(among_)},
            {"sure", sure_},
            {"sure_wrong", sure_wrong_},
            {"ms_median", quantile(50)},
            {"ms_p95", quantile(95)}};
  }
  const nlohmann::json& images() const { return images_; }

 private:
  const ImageTrialOptions& options_;
  LocalizationMap map_;
  RandomSource random_;
  std::unique_ptr<PoseSearch> search_;
  nlohmann::json images_ = nlohmann::json::array();
  std::vector<double> ms_;
  int first_ = 0, among_ = 0, sure_ = 0, sure_wrong_ = 0;
};

/// Asks for the first images of random flights.
std::unique_ptr<ImageTrials> askInSimulation(const ImageTrialOptions& o) {
  if (o.every > 0) throw ParameterError("--every is for a recorded sequence");
  auto trials = std::make_unique<ImageTrials>(
      o, o.model.empty() ? Scenario::fromYamlFile(o.source).model_file : o.model);
  const int count = o.count > 0 ? o.count : 50;
  ProgressBar bar("images", static_cast<size_t>(count));
  for (int k = 0; k < count; ++k) {
    TrialFlight flight(o.source, TrialKind::kGlobal, o.first_seed + static_cast<uint64_t>(k), 10, 1,
                       0, 0, 0);
    RecordedFrame frame;
    if (flight.next(&frame)) trials->ask({flight.camera(), frame.color, frame.mask, *frame.truth});
    bar.advance();
  }
  return trials;
}

/// Asks for some images of a recording.
std::unique_ptr<ImageTrials> askInRecording(const ImageTrialOptions& o) {
  if (o.count > 0) throw ParameterError("--count is for a scenario");
  const size_t every = o.every > 0 ? static_cast<size_t>(o.every) : 10;
  const Sequence sequence = readSequence(o.source);
  const std::string model = o.model.empty() ? sequence.model_file : o.model;
  if (model.empty()) throw InputError(o.source + ": has no model.obj; give --model");
  auto trials = std::make_unique<ImageTrials>(o, model);
  ProgressBar bar("images", sequence.frames.size());
  for (size_t i = 0; i < sequence.frames.size(); ++i) {
    bar.advance();
    const SequenceFrame& frame = sequence.frames[i];
    if (i % every != 0 || !frame.ground_truth) continue;
    trials->ask({sequence.camera, readImage(frame.image_file, sequence.camera),
                 frame.mask_file.empty() ? cv::Mat() : readMask(frame.mask_file, sequence.camera),
                 *frame.ground_truth});
  }
  return trials;
}

int run(const ImageTrialOptions& o) {
  checkOutput(o.out);
  const std::unique_ptr<ImageTrials> trials =
      std::filesystem::is_directory(o.source) ? askInRecording(o) : askInSimulation(o);
  const nlohmann::json summary = trials->summary();
  if (!o.out.empty()) writeJson(o.out, {{"summary", summary}, {"images", trials->images()}});
  if (o.json)
    std::printf("%s\n", textOf(summary).c_str());
  else
    std::printf(
        "%s: %d images, first answer right %.1f %%, truth among %zu answers %.1f %%; %d sure, of "
        "these %d wrong; "
        "median %.0f ms, 95 %% %.0f ms\n",
        o.source.c_str(), summary["images"].get<int>(), 100 * summary["first_right"].get<double>(),
        o.answers, 100 * summary["among_answers"].get<double>(), summary["sure"].get<int>(),
        summary["sure_wrong"].get<int>(), summary["ms_median"].get<double>(),
        summary["ms_p95"].get<double>());
  return kExitOk;
}

}  // namespace

void addImageTrials(CLI::App* app, Action* action) {
  auto o = std::make_shared<ImageTrialOptions>();
  CLI::App* c = app->add_subcommand(
      "image-trials",
      "ask where single images were taken whose pose is known, and count the right answers");
  c->add_option("source", o->source,
                "a scenario as for simulate (random poses are tried), or a recorded sequence with "
                "ground truth")
      ->required();
  c->add_option("--model", o->model, "model of the building; default: that of the source");
  c->add_option("--count", o->count, "number of random poses of a scenario; default 50")
      ->check(CLI::Range(1, 1000000));
  c->add_option("--every", o->every, "every so many-th image of a sequence; default 10")
      ->check(CLI::Range(1, 1000000));
  c->add_option("--first-seed", o->first_seed, "seed of the first random pose; default 1");
  c->add_flag("--no-gravity", o->no_gravity,
              "do not give roll and pitch; default: they are given (--imu-sigma)");
  c->add_option("--imu-sigma", o->imu_sigma_deg,
                "standard deviation of the given roll and pitch, degrees; default 1")
      ->check(numberFrom(0, 90));
  c->add_flag("--no-mask", o->no_mask, "do not use masks; default: those of the source are used");
  c->add_option("--answers", o->answers, "largest number of poses in an answer; default 5")
      ->check(CLI::Range(1, 100));
  c->add_option("--out", o->out, "JSON file with all answers; default: none");
  c->add_flag("--json", o->json, "print the summary as JSON; default: as text");
  o->parameters.addTo(c);
  c->callback([o, action] { *action = [o] { return run(*o); }; });
}

}  // namespace edge_mcl
