#include "edge_mcl/gpu/cuda_backend.h"

#include "edge_mcl/core/error.h"
#include "edge_mcl/gpu/conversion.h"
#include "edge_mcl/gpu/engine.h"

namespace edge_mcl {

namespace {

/// Cells on the device before all are dropped and uploaded anew as they are needed.
constexpr size_t kMostCells = 16384;

std::unique_ptr<gpu::Engine> makeEngine(const EdgeModel& model) {
  try {
    auto engine = std::make_unique<gpu::Engine>();
    engine->setModel(model.sample_along.data(), model.sample_along.size());
    return engine;
  } catch (const gpu::DeviceError& e) {
    throw Error(e.what());
  }
}

}  // namespace

std::string CudaBackend::whyUnavailable() { return gpu::Engine::whyUnavailable(); }

CudaBackend::CudaBackend(std::shared_ptr<const Visibility> visibility,
                         std::function<void(const std::string&)> warn)
    : visibility_(std::move(visibility)),
      warn_(std::move(warn)),
      fallback_(visibility_),
      engine_(makeEngine(visibility_->model())) {}

CudaBackend::~CudaBackend() = default;

std::string CudaBackend::name() const {
  std::lock_guard<std::mutex> lock(mutex_);
  return engine_ ? "cuda " + engine_->deviceName() : fallback_.name();
}

uint32_t CudaBackend::cellNumber(const CellKey& key) const {
  const auto known = cells_.find(key);
  if (known != cells_.end()) return known->second;
  const gpu::CellData data = gpu::cellOf(*visibility_->cached(key), visibility_->cellCentre(key));
  const uint32_t number = engine_->addCell(data.cell, data.segments.data(), data.segments.size(),
                                           data.group_ends.data(), data.group_ends.size());
  cells_.emplace(key, number);
  return number;
}

std::vector<PoseScore> CudaBackend::evaluateOnDevice(const LikelihoodFrame& frame,
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

std::vector<PoseScore> CudaBackend::evaluate(const LikelihoodFrame& frame,
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
