/// Times the likelihood of one image: the paper's flow, plainly written, against the CPU backend.
#pragma once

#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "apps/bench/stage_times.h"
#include "edge_mcl/core/base/random_source.h"
#include "edge_mcl/core/likelihood/cpu_backend.h"
#include "edge_mcl/core/localization_map.h"
#include "edge_mcl/core/recordings/sequence.h"

namespace edge_mcl {

/// What is timed.
struct BenchSettings {
  size_t image = 0;              ///< number of the image in the sequence
  size_t samples = 0;            ///< samples per particle after thinning; 0: all
  size_t plain_particles = 100;  ///< particles timed with the plain flow, which is scaled up
  size_t updates = 60;           ///< images whose whole update is timed
  int repeats = 15;              ///< measurements; the median counts
  double spread_position = 0.05, spread_angle_deg = 2;  ///< of the particles, per axis; m, deg
};

class LikelihoodBench {
 public:
  /// Draws the particles and prepares the image. The map is on the CPU until `timeBackend`.
  /// @throws InputError when the image cannot be read; ParameterError when there is none
  LikelihoodBench(std::shared_ptr<LocalizationMap> map, const Sequence& sequence,
                  const BenchSettings& settings);

  /// Times the plain flow, one thread and all threads in turns, then whole updates on the CPU.
  void timeCpu();
  /// Gives the map the backend of its parameters and times whole updates on a device, if there is
  /// one.
  void timeBackend();
  /// Times every number of particles on the CPU and the device, as the paper's Table 1.
  nlohmann::json timeSizes(const std::vector<size_t>& sizes, bool print) const;
  /// Writes image, model, particles and the CPU's results for `edge_mcl_gpu_check`.
  void dumpWorkload(const std::string& file) const;

  const std::vector<Pose>& poses() const { return poses_; }
  nlohmann::json toJson() const;
  void print() const;

 private:
  std::vector<Pose> draw(size_t count) const;
  size_t plainCount() const { return std::min(poses_.size(), settings_.plain_particles); }
  bool hasDevice() const;

  std::shared_ptr<LocalizationMap> map_;
  const Sequence& sequence_;
  BenchSettings settings_;
  CpuBackend cpu_;
  cv::Mat picture_;
  Pose centre_;
  mutable RandomSource random_;
  std::vector<Pose> poses_;
  std::shared_ptr<const PreparedImage> image_;
  LikelihoodFrame frame_;
  std::vector<PoseScore> reference_;
  double plain_ms_ = 0, one_ms_ = 0, all_ms_ = 0;  // all particles: plain flow, one, all threads
  double image_ms_ = 0;                            // edges and table, one thread
  double gather_limit_ = 0;  // ns per particle-sample, look-ups alone, one thread
  uint64_t samples_ = 0;     // particle-samples evaluated
  double checksum_ = 0;      // keeps the compiler from dropping the plain flow
  StageTable updates_one_, updates_all_, updates_device_;
};

}  // namespace edge_mcl
