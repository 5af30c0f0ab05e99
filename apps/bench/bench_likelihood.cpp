#include "apps/bench/bench_likelihood.h"

#include <tbb/global_control.h>
#include <tbb/info.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <functional>

#include "apps/bench/bench_table.h"
#include "apps/bench/gather_limit.h"
#include "apps/bench/soak.h"
#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/image/pixel_scale.h"
#include "edge_mcl/core/likelihood/cpu_kernel.h"
#include "edge_mcl/core/likelihood/reference_likelihood.h"
#include "edge_mcl/core/recordings/trajectory_evaluation.h"
#include "edge_mcl/gpu/backend/workload_export.h"
#include "edge_mcl/localization/map_factory.h"

namespace edge_mcl {

namespace {

double millisecondsOf(const std::function<void()>& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
      .count();
}

double median(std::vector<double> values) { return summarize(std::move(values)).median; }

void withOneThread(const std::function<void()>& work) {
  tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
  work();
}

const SequenceFrame& frameOf(const Sequence& sequence, size_t image) {
  if (image >= sequence.frames.size()) throw ParameterError("--image: no such image");
  return sequence.frames[image];
}

/// The grey picture of a prepared image, as a device gets it.
Picture pictureOf(const PreparedImage& image, const Parameters& params) {
  return Picture(image.edges.grey, image.edges.ignore, params.image,
                 std::make_shared<ScoreLevels>(params.image, params.likelihood));
}

}  // namespace

LikelihoodBench::LikelihoodBench(std::shared_ptr<LocalizationMap> map, const Sequence& sequence,
                                 const BenchSettings& settings)
    : map_(std::move(map)),
      sequence_(sequence),
      settings_(settings),
      cpu_(map_->sharedVisibility()),
      random_(map_->params().filter.seed) {
  const SequenceFrame& frame = frameOf(sequence, settings.image);
  picture_ = readImage(frame.image_file, sequence.camera);
  centre_ = frame.ground_truth ? *frame.ground_truth : startOf(sequence);
  poses_ = draw(static_cast<size_t>(map_->params().filter.particles));
  image_ = map_->prepare(sequence.camera, picture_, {}, frame.image_file);
  frame_ = image_->frame;
  if (settings.samples > 0)
    frame_.thinning = map_->thinningFor({image_}, centre_, settings.samples);
  reference_ = cpu_.evaluate(frame_, poses_);  // fills the visibility cache, too
}

std::vector<Pose> LikelihoodBench::draw(size_t count) const {
  Vector6 scale;
  scale.head<3>().setConstant(settings_.spread_position);
  scale.tail<3>().setConstant(settings_.spread_angle_deg * M_PI / 180);
  std::vector<Pose> drawn;
  drawn.reserve(count);
  for (size_t i = 0; i < count; ++i)
    drawn.push_back(centre_ * expSe3(scale.cwiseProduct(random_.normalTwist())));
  return drawn;
}

void LikelihoodBench::timeCpu() {
  constexpr int kPlainRepeats = 3;  // the plain flow takes seconds, so its scatter is small
  std::vector<double> one, all, plain, image, gathers;
  LikelihoodFrame paper = frame_;
  paper.params.model = LikelihoodModel::kPaper;
  const ImageParameters flow_params = scaledBy(image_->pixel_scale, map_->params().image);
  const Visibility& visibility = map_->visibility();
  const auto centre_set = visibility.cached(visibility.cellOf(centre_.translation()));
  const std::string& file = sequence_.frames[settings_.image].image_file;
  // The contenders take turns, so that a drifting clock rate affects all of them.
  for (int k = 0; k < settings_.repeats; ++k) {
    if (k < kPlainRepeats)
      plain.push_back(millisecondsOf([&] {
        for (size_t i = 0; i < plainCount(); ++i)
          checksum_ += paperFlowScore(paper, image_->edges, flow_params, visibility, poses_[i])
                           .log_likelihood;
      }));
    withOneThread([&] {
      one.push_back(millisecondsOf([&] { cpu_.evaluate(frame_, poses_); }));
      gathers.push_back(gatherLimitNanoseconds(frame_, *centre_set, poses_, 1));
      image.push_back(millisecondsOf([&] { map_->prepare(sequence_.camera, picture_, {}, file); }));
    });
    all.push_back(millisecondsOf([&] { cpu_.evaluate(frame_, poses_); }));
  }
  samples_ = cpu_.lastEvaluatedSamples();
  gather_limit_ = median(gathers);
  withOneThread([&] { updates_one_ = StageTable::measure(map_, sequence_, settings_.updates); });
  updates_all_ = StageTable::measure(map_, sequence_, settings_.updates);
  plain_ms_ =
      median(plain) * static_cast<double>(poses_.size()) / static_cast<double>(plainCount());
  one_ms_ = median(one);
  all_ms_ = median(all);
  image_ms_ = median(image);
}

bool LikelihoodBench::hasDevice() const { return map_->backend().name().rfind("cuda", 0) == 0; }

void LikelihoodBench::timeBackend() {
  chooseBackend(map_.get());
  if (hasDevice()) updates_device_ = StageTable::measure(map_, sequence_, settings_.updates);
}

nlohmann::json LikelihoodBench::timeSizes(const std::vector<size_t>& sizes, bool print) const {
  return timeTable(
      cpu_, hasDevice() ? &map_->backend() : nullptr, frame_, pictureOf(*image_, map_->params()),
      plain_ms_ / static_cast<double>(poses_.size()), sizes,
      [this](size_t count) { return draw(count); }, print);
}

void LikelihoodBench::dumpWorkload(const std::string& file) const {
  const Picture source = pictureOf(*image_, map_->params());
  gpu::Workload w =
      gpu::makeWorkload(sequence_.name, map_->visibility(), frame_, poses_, reference_, &source);
  w.plain_ms = plain_ms_;
  w.cpu_ms = all_ms_;
  gpu::writeWorkload(w, file);
}

nlohmann::json LikelihoodBench::toJson() const {
  const double per_sample = 1e6 * one_ms_ / static_cast<double>(samples_);
  return {{"sequence", sequence_.name},
          {"likelihood", map_->params().get("likelihood.model")},
          {"particles", poses_.size()},
          {"thinning", frame_.thinning},
          {"particle_samples", samples_},
          {"instruction_set", kernelTargetName()},
          {"threads", tbb::info::default_concurrency()},
          {"plain_flow_ms", plain_ms_},
          {"plain_flow_particles_timed", plainCount()},
          {"cpu_one_thread_ms", one_ms_},
          {"cpu_all_threads_ms", all_ms_},
          {"image_one_thread_ms", image_ms_},
          {"ns_per_particle_sample_one_thread", per_sample},
          {"ns_per_particle_sample_gathers_alone", gather_limit_},
          {"ratio_one_thread_to_gathers_alone", per_sample / gather_limit_},
          {"ratio_plain_to_one_thread", plain_ms_ / one_ms_},
          {"ratio_plain_to_one_thread_with_image", plain_ms_ / (one_ms_ + image_ms_)},
          {"ratio_one_to_all_threads", one_ms_ / all_ms_},
          {"update_ms_one_thread", updates_one_.toJson()},
          {"update_ms_all_threads", updates_all_.toJson()},
          {"backend", map_->backend().name()},
          {"update_ms_gpu", updates_device_.toJson()},
          {"peak_resident_mb", peakResidentMegabytes()},
          {"checksum", checksum_}};
}

void LikelihoodBench::print() const {
  const double samples = static_cast<double>(samples_);
  const std::string threads = std::to_string(tbb::info::default_concurrency()) + " threads";
  std::printf("%s, image %zu: %zu particles, %.0f samples each (after culling), %s\n",
              sequence_.name.c_str(), settings_.image, poses_.size(),
              samples / static_cast<double>(poses_.size()), kernelTargetName());
  std::printf("  %-42s %10s %16s %8s\n", "", "ms", "ns/part.-sample", "ratio");
  const auto row = [&](const std::string& name, double ms) {
    std::printf("  %-42s %10.2f %16.2f %8.1f\n", name.c_str(), ms, 1e6 * ms / samples,
                plain_ms_ / ms);
  };
  row("paper's flow, plainly written, 1 thread", plain_ms_);
  row("CPU backend, 1 thread", one_ms_);
  row("CPU backend, " + threads, all_ms_);
  std::printf("  %-42s %10s %16.2f   the backend takes %.2f times that\n",
              "look-ups alone, 1 thread", "", gather_limit_,
              1e6 * one_ms_ / samples / gather_limit_);
  std::printf("  edges and table of the image, 1 thread     %10.2f ms (once per image)\n",
              image_ms_);
  updates_one_.print("whole update, image in, pose out, 1 thread");
  updates_all_.print("whole update, " + threads);
  updates_device_.print("whole update, " + map_->backend().name());
  std::printf("  peak resident size %.0f MB\n", peakResidentMegabytes());
}

}  // namespace edge_mcl
