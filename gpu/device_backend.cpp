#include "edge_mcl/gpu/device_backend.h"

#include "edge_mcl/gpu/conversion.h"

namespace edge_mcl {

namespace {

/// Cells on the device before all are dropped and uploaded anew as they are needed.
constexpr size_t kMostCells = 16384;

}  // namespace

DeviceBackend::DeviceBackend(std::string kind, std::unique_ptr<gpu::ScoringEngine> engine,
                             std::shared_ptr<const Visibility> visibility,
                             std::function<void(const std::string&)> warn)
    : kind_(std::move(kind)),
      visibility_(std::move(visibility)),
      warn_(std::move(warn)),
      fallback_(visibility_),
      engine_(std::move(engine)) {
  const EdgeModel& model = visibility_->model();
  engine_->setModel(model.sample_along.data(), model.sample_along.size());
}

DeviceBackend::~DeviceBackend() = default;

std::string DeviceBackend::name() const {
  std::lock_guard<std::mutex> lock(mutex_);
  return engine_ ? kind_ + " " + engine_->deviceName() : fallback_.name();
}

uint32_t DeviceBackend::cellNumber(const CellKey& key) const {
  const auto known = cells_.find(key);
  if (known != cells_.end()) return known->second;
  const gpu::CellData data = gpu::cellOf(*visibility_->cached(key), visibility_->cellCentre(key));
  const uint32_t number = engine_->addCell(data.cell, data.segments.data(), data.segments.size(),
                                           data.group_ends.data(), data.group_ends.size());
  cells_.emplace(key, number);
  return number;
}

std::vector<PoseScore> DeviceBackend::evaluateOnDevice(const LikelihoodFrame& frame,
                                                       const std::vector<Pose>& poses) const {
  if (table_ != frame.table) {
    const ScoreTable& t = *frame.table;
    table_ = nullptr;
    engine_->setImage(gpu::cameraOf(frame.camera), gpu::tableOf(t), t.pairs(), t.pairCount());
    table_ = frame.table;
  }
  if (cells_.size() > kMostCells) {
    engine_->clearCells();
    cells_.clear();
  }
  std::vector<gpu::Particle> particles;
  particles.reserve(poses.size());
  for (const Pose& pose : poses)
    particles.push_back(gpu::particleOf(pose, cellNumber(visibility_->cellOf(pose.translation()))));
  std::vector<gpu::Result> results(poses.size());
  engine_->score(gpu::ruleOf(frame), gpu::combinationOf(frame.params), particles.data(),
                 particles.size(), results.data());
  std::vector<PoseScore> scores;
  scores.reserve(results.size());
  for (const gpu::Result& r : results)
    scores.push_back({r.log_likelihood, r.sample_weight, r.line_count});
  return scores;
}

std::vector<PoseScore> DeviceBackend::evaluate(const LikelihoodFrame& frame,
                                               const std::vector<Pose>& camera_poses) const {
  checkLikelihoodInput(frame, camera_poses);
  {
    std::lock_guard<std::mutex> lock(mutex_);
    // Exact visibility gives every pose a set of its own: nothing to keep on a device.
    try {
      if (engine_ && !visibility_->exactMode()) return evaluateOnDevice(frame, camera_poses);
    } catch (const gpu::DeviceError& e) {
      engine_.reset();
      cells_.clear();
      table_ = nullptr;
      if (warn_) warn_(std::string(e.what()) + "; continuing on the CPU");
    }
  }
  return fallback_.evaluate(frame, camera_poses);
}

}  // namespace edge_mcl
