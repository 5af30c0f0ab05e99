#include "edge_mcl/gpu/backend/device_backend.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <iterator>
#include <new>
#include <optional>
#include <tuple>

#include "edge_mcl/gpu/backend/cell_packing.h"
#include "edge_mcl/gpu/backend/conversion.h"

namespace edge_mcl {

namespace {

/// Limit of the cells' memory on the device. Above it all cells are dropped and uploaded again when
/// they are needed.
constexpr size_t kMostCellBytes = size_t{1} << 30;
/// Number of particles that are sent together. While the device scores a batch, the host prepares
/// the next one.
size_t batchFor(size_t particles) {
  return std::clamp(particles / 4, size_t{16384}, size_t{131072});
}
constexpr size_t kMostRecipes = 8;

bool isSame(const gpu::Camera& a, const gpu::Camera& b) {
  // All other members depend on these.
  const auto numbers = [](const gpu::Camera& c) {
    return std::tie(c.fx, c.fy, c.cx, c.cy, c.last_x, c.last_y, c.distortion);
  };
  return numbers(a) == numbers(b) && std::equal(std::begin(a.k), std::end(a.k), std::begin(b.k));
}

/// Number of particles that a thread prepares at once.
constexpr size_t kGrain = 512;

}  // namespace

DeviceBackend::DeviceBackend(std::string kind, std::unique_ptr<gpu::ScoringEngine> engine,
                             std::shared_ptr<const Visibility> visibility,
                             std::function<void(const std::string&)> warn)
    : kind_(std::move(kind)),
      visibility_(std::move(visibility)),
      warn_(std::move(warn)),
      fallback_(visibility_),
      engine_(std::move(engine)) {}

DeviceBackend::~DeviceBackend() = default;

std::string DeviceBackend::name() const {
  std::lock_guard<std::mutex> lock(mutex_);
  return engine_ ? kind_ + " " + engine_->deviceName() : fallback_.name();
}

bool DeviceBackend::makesTables(const ImageParameters& params) const {
  std::lock_guard<std::mutex> lock(mutex_);
  return engine_ && gpu::canMakeTables(params);
}

void DeviceBackend::prefetch(const LikelihoodFrame& frame) const {
  checkFrame(frame);
  std::lock_guard<std::mutex> lock(mutex_);
  try {
    if (engine_) imageOf(frame);
  } catch (const gpu::DeviceError& e) {
    giveUp(e);
  }
}

const gpu::TableRecipe& DeviceBackend::recipeFor(const Picture& picture) const {
  const int width = picture.grey().cols, height = picture.grey().rows;
  const auto known = std::find_if(recipes_.begin(), recipes_.end(), [&](const Recipe& r) {
    return r.levels == picture.levels() && r.recipe.work.width == width &&
           r.recipe.work.height == height;
  });
  if (known != recipes_.end()) {
    recipes_.splice(recipes_.end(), recipes_, known);
  } else {
    recipes_.push_back(
        {picture.levels(), gpu::recipeOf(width, height, picture.params(), *picture.levels())});
    // The oldest recipe is not in use: the engine refers at most to the one before the newest.
    if (recipes_.size() > kMostRecipes) recipes_.pop_front();
  }
  return recipes_.back().recipe;
}

/// Returns the number of the frame's table on the device. Uploads the table when it is missing.
int DeviceBackend::imageOf(const LikelihoodFrame& frame) const {
  const std::shared_ptr<const void> owner =
      frame.table ? std::shared_ptr<const void>(frame.table) : frame.picture;
  const gpu::Camera camera = gpu::cameraOf(frame.camera);
  int oldest = 0;
  for (int i = 0; i < gpu::ScoringEngine::kImages; ++i) {
    if (held_[i].owner == owner && isSame(held_[i].camera, camera)) {
      held_[i].used = ++calls_;
      return i;
    }
    if (held_[i].used < held_[oldest].used) oldest = i;
  }
  held_[oldest] = {};
  if (frame.table || !gpu::canMakeTables(frame.picture->params())) {
    const std::shared_ptr<const ScoreTable> t = frame.tableHere();
    engine_->setTable(oldest, camera, gpu::tableOf(*t), t->pairs(), t->pairCount());
  } else {
    engine_->setPicture(oldest, camera, gpu::tableOf(*frame.picture), recipeFor(*frame.picture),
                        gpu::dataOf(*frame.picture));
  }
  held_[oldest] = {owner, ++calls_, camera};
  return oldest;
}

void DeviceBackend::addCells(std::vector<CellKey> keys, uint32_t thinning) const {
  std::sort(keys.begin(), keys.end());
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
  // Packed cells take many times the memory of cells in the cache, so they are packed in batches.
  constexpr size_t kAtOnce = 256;
  for (size_t first = 0; first < keys.size(); first += kAtOnce) {
    std::vector<gpu::CellData> data(std::min(kAtOnce, keys.size() - first));
    tbb::parallel_for(size_t{0}, data.size(), [&](size_t i) {
      const CellKey& key = keys[first + i];
      data[i] = gpu::packCell(*visibility_->cached(key), visibility_->cellCentre(key), thinning);
    });
    for (size_t i = 0; i < data.size(); ++i) {
      cells_.emplace(CellName{keys[first + i], thinning},
                     engine_->addCell(data[i].cell, data[i].chunks.data(), data[i].samples.data()));
      cell_bytes_ +=
          data[i].chunks.size() * sizeof(gpu::Chunk) + data[i].samples.size() * sizeof(gpu::Sample);
    }
  }
}

/// Converts the poses [first, last) to particles. Uploads the cells that the device does not have.
void DeviceBackend::fill(const std::vector<Pose>& poses, uint32_t thinning, size_t first,
                         size_t last, gpu::Particle* particles) const {
  while (true) {
    std::mutex missing_mutex;
    std::vector<CellKey> missing;
    tbb::parallel_for(
        tbb::blocked_range<size_t>(first, last, kGrain), [&](const tbb::blocked_range<size_t>& r) {
          std::vector<CellKey> unknown;
          std::optional<CellKey> known;  // most poses are in the cell of the pose before
          uint32_t number = 0;
          for (size_t i = r.begin(); i < r.end(); ++i) {
            checkPose(poses[i]);
            const CellKey key = visibility_->cellOf(poses[i].translation());
            if (!known || !(key == *known)) {
              const auto entry = cells_.find({key, thinning});
              if (entry == cells_.end()) {
                unknown.push_back(key);
                continue;
              }
              known = key;
              number = entry->second;
            }
            particles[i] = gpu::particleOf(poses[i], number);
          }
          if (unknown.empty()) return;
          std::lock_guard<std::mutex> lock(missing_mutex);
          missing.insert(missing.end(), unknown.begin(), unknown.end());
        });
    if (missing.empty()) return;
    // New cells may move the device's memory, so all scoring must be finished.
    engine_->wait();
    addCells(std::move(missing), thinning);
  }
}

std::vector<PoseScore> DeviceBackend::evaluateOnDevice(const LikelihoodFrame& frame,
                                                       const std::vector<Pose>& poses) const {
  const int image = imageOf(frame);
  const gpu::Rule rule = gpu::ruleOf(frame);
  const gpu::Combination combination = gpu::combinationOf(frame.params);
  gpu::Particle* particles = engine_->particles(poses.size());
  const size_t batch = batchFor(poses.size());
  for (size_t first = 0; first < poses.size(); first += batch) {
    const size_t last = std::min(poses.size(), first + batch);
    if (cell_bytes_ > kMostCellBytes) {
      engine_->wait();
      engine_->clearCells();
      cells_.clear();
      cell_bytes_ = 0;
    }
    fill(poses, frame.thinning, first, last, particles);
    engine_->submit(image, rule, combination, first, last - first);
  }
  std::vector<PoseScore> scores(
      poses.size());  // allocated before waiting, because this takes time for a million
  const gpu::Result* results = engine_->wait();
  tbb::parallel_for(tbb::blocked_range<size_t>(0, poses.size(), 8 * kGrain),
                    [&](const tbb::blocked_range<size_t>& range) {
                      for (size_t i = range.begin(); i < range.end(); ++i) {
                        scores[i].log_likelihood = results[i].log_likelihood;
                        scores[i].sample_weight = results[i].sample_weight;
                        scores[i].line_count = results[i].line_count;
                      }
                    });
  return scores;
}

void DeviceBackend::giveUp(const gpu::DeviceError& error) const {
  engine_.reset();
  cells_.clear();
  held_ = {};
  if (warn_) warn_(std::string(error.what()) + "; continuing on the CPU");
}

std::vector<PoseScore> DeviceBackend::evaluate(const LikelihoodFrame& frame,
                                               const std::vector<Pose>& camera_poses) const {
  checkFrame(frame);
  {
    std::lock_guard<std::mutex> lock(mutex_);
    try {
      if (engine_) return evaluateOnDevice(frame, camera_poses);
    } catch (const gpu::DeviceError& e) {
      giveUp(e);
    } catch (const std::bad_alloc&) {
      giveUp(gpu::DeviceError("no memory to prepare the model for the device"));
    }
  }
  return fallback_.evaluate(frame, camera_poses);
}

}  // namespace edge_mcl
