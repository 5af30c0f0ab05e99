#include "edge_mcl/comparison/compared_run.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fstream>

#include "edge_mcl/comparison/compared_methods.h"
#include "edge_mcl/core/base/angles.h"
#include "edge_mcl/core/base/error.h"
#include "edge_mcl/localization/recorded/sequence_input.h"

namespace edge_mcl {

namespace {

constexpr double kSuccessPosition = 0.10, kSuccessAngle = 3;  // m, deg
constexpr double kLostPosition = 0.25, kLostAngle = 5;        // m, deg

/// Returns the largest resident size of this process. getrusage() is no substitute: it reports the
/// size of the parent process when that was larger.
double peakMegabytes() {
  std::ifstream in("/proc/self/status");
  for (std::string line; std::getline(in, line);)
    if (line.rfind("VmHWM:", 0) == 0) return std::stod(line.substr(6)) / 1024;
  return 0;
}

nlohmann::json toJson(const ErrorSummary& s) {
  return {{"mean", s.mean}, {"median", s.median}, {"rmse", s.rmse}, {"p90", s.p90}, {"max", s.max}};
}

ErrorSummary summaryFromJson(const nlohmann::json& j) {
  return {j.at("mean"), j.at("median"), j.at("rmse"), j.at("p90"), j.at("max")};
}

}  // namespace

ComparedRun runCompared(const std::string& method_name, const std::string& directory, uint64_t seed,
                        int particles) {
  const ComparedMethod& method = comparedMethod(method_name);
  const Sequence sequence = readSequence(directory);
  if (sequence.model_file.empty()) throw InputError(directory + ": no model.obj in it");
  ComparedRun run;
  run.method = method_name;
  run.sequence = sequence.name;
  run.seed = seed;
  run.particles = method.hasParticles() ? particles : 0;
  std::vector<double> position, plane, rotation, ms;
  size_t good = 0;
  const auto with_truth =
      std::count_if(sequence.frames.begin(), sequence.frames.end(),
                    [](const SequenceFrame& f) { return f.ground_truth.has_value(); });
  if (with_truth == 0) throw InputError(directory + ": no image with ground truth");
  try {
    const auto filter = makeFilter(method, sequence, particles, seed);
    filter->initialize(
        initialGaussian(sequence, sequence.initial_std_position, sequence.initial_std_angle));
    for (const SequenceFrame& frame : sequence.frames) {
      if (!frame.ground_truth) continue;
      std::string problem;
      const LiveInput input = readInput(sequence, frame, {true, method.uses_masks, true}, &problem);
      if (!problem.empty()) throw InputError(problem);
      const auto start = std::chrono::steady_clock::now();
      const Pose pose = filter->process(input, *frame.ground_truth);
      ms.push_back(
          std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start)
              .count());
      const Eigen::Vector3d off = pose.translation() - frame.ground_truth->translation();
      if (!off.allFinite()) throw Error("the filter returned a pose that is not finite");
      const double angle = rotationAngle(pose, *frame.ground_truth) / kDegree;
      position.push_back(off.norm());
      plane.push_back(off.head<2>().norm());
      rotation.push_back(angle);
      good += off.norm() < kSuccessPosition && angle < kSuccessAngle ? 1 : 0;
      run.lost = off.norm() > kLostPosition || angle > kLostAngle;
      run.time.push_back(frame.time - sequence.frames.front().time);
    }
  } catch (const InputError&) {
    throw;
  } catch (const std::exception& e) {
    run.failure = e.what();
    run.lost = true;
  }
  run.images = position.size();
  run.success = static_cast<double>(good) / static_cast<double>(with_truth);
  run.position = summarize(position);
  run.plane = summarize(plane);
  run.rotation = summarize(rotation);
  run.update_ms = summarize(ms);
  run.peak_mb = peakMegabytes();
  run.position_series = std::move(position);
  return run;
}

nlohmann::json toJson(const ComparedRun& r) {
  return {{"method", r.method},
          {"sequence", r.sequence},
          {"seed", r.seed},
          {"particles", r.particles},
          {"failure", r.failure},
          {"images", r.images},
          {"position_m", toJson(r.position)},
          {"plane_m", toJson(r.plane)},
          {"rotation_deg", toJson(r.rotation)},
          {"success", r.success},
          {"lost", r.lost},
          {"update_ms", toJson(r.update_ms)},
          {"peak_mb", r.peak_mb},
          {"time", r.time},
          {"position_series_m", r.position_series}};
}

ComparedRun runFromJson(const nlohmann::json& j, const std::string& origin) {
  try {
    ComparedRun r;
    r.method = j.at("method");
    r.sequence = j.at("sequence");
    r.seed = j.at("seed");
    r.particles = j.at("particles");
    r.failure = j.at("failure");
    r.images = j.at("images");
    r.position = summaryFromJson(j.at("position_m"));
    r.plane = summaryFromJson(j.at("plane_m"));
    r.rotation = summaryFromJson(j.at("rotation_deg"));
    r.success = j.at("success");
    r.lost = j.at("lost");
    r.update_ms = summaryFromJson(j.at("update_ms"));
    r.peak_mb = j.at("peak_mb");
    r.time = j.at("time").get<std::vector<double>>();
    r.position_series = j.at("position_series_m").get<std::vector<double>>();
    return r;
  } catch (const nlohmann::json::exception& e) {
    throw InputError(origin + ": not a stored run: " + e.what());
  }
}

}  // namespace edge_mcl
