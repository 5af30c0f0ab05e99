#include "edge_mcl/gpu/device_backend.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "edge_mcl/core/localization_map.h"
#include "edge_mcl/gpu/emulated_engine.h"
#include "edge_mcl/mrpt_plugins/pose_filter.h"
#include "support/scenes.h"

namespace edge_mcl {
namespace {

const Pose kView = test::lookAlong({3.2, 2.5, 1.4}, {-1, -0.5, -0.15});

/// Works until call number `fails_at` of what is counted, then throws as a lost device does.
class FailingEngine : public gpu::EmulatedEngine {
 public:
  enum class Call { kScore, kSetImage, kAddCell };
  FailingEngine(Call call, int fails_at) : call_(call), left_(fails_at) {}
  uint32_t addCell(gpu::Cell cell, const gpu::Segment* segments, size_t segment_count,
                   const uint32_t* group_ends, size_t group_count) override {
    count(Call::kAddCell);
    return EmulatedEngine::addCell(cell, segments, segment_count, group_ends, group_count);
  }
  void setImage(const gpu::Camera& camera, const gpu::Table& table, const uint16_t* pairs,
                size_t n) override {
    count(Call::kSetImage);
    EmulatedEngine::setImage(camera, table, pairs, n);
  }
  void score(const gpu::Rule& rule, const gpu::Combination& combination,
             const gpu::Particle* particles, size_t n, gpu::Result* results) override {
    count(Call::kScore);
    EmulatedEngine::score(rule, combination, particles, n, results);
  }

 private:
  void count(Call call) {
    if (call == call_ && --left_ == 0) throw gpu::DeviceError("device lost");
  }
  Call call_;
  int left_;
};

class DeviceBackendTest : public testing::Test {
 protected:
  LocalizationMap map_{test::furnishedRooms(), Parameters()};
  CameraModel camera_ = test::pinhole(320, 240, 220);
  cv::Mat picture_ = test::render(test::furnishedRooms(), camera_, kView, 1);

  std::vector<Pose> cloud(size_t n, uint64_t seed) const {
    RandomSource random(seed);
    std::vector<Pose> poses;
    Twist scale;
    scale << 0.1, 0.1, 0.1, 0.05, 0.05, 0.05;
    for (size_t i = 0; i < n; ++i)
      poses.push_back(kView * expSe3(scale.cwiseProduct(random.normalTwist())));
    return poses;
  }

  std::shared_ptr<const PreparedImage> prepare() const {
    return map_.prepare(camera_, picture_, {}, "room");
  }
};

TEST_F(DeviceBackendTest, AgreesWithTheCpuOverSeveralImagesAndAtEveryThinning) {
  const DeviceBackend device("test", std::make_unique<gpu::EmulatedEngine>(),
                             map_.sharedVisibility(), {});
  EXPECT_EQ(device.name(), "test emulation on the host");
  const CpuBackend cpu(map_.sharedVisibility());
  for (const uint32_t thinning : {1u, 2u, 7u, 40u}) {
    LikelihoodFrame frame = prepare()->frame;
    frame.thinning = thinning;
    const std::vector<Pose> poses = cloud(200, thinning);
    const auto a = device.evaluate(frame, poses), b = cpu.evaluate(frame, poses);
    for (size_t i = 0; i < poses.size(); ++i) {
      EXPECT_NEAR(a[i].log_likelihood, b[i].log_likelihood, 1e-3);
      EXPECT_NEAR(a[i].sample_weight, b[i].sample_weight, 1e-3 * (1 + b[i].sample_weight));
    }
  }
}

/// The frame in which the device is lost is computed anew on the CPU; one line says so; all later
/// frames have exactly the CPU's bits.
TEST_F(DeviceBackendTest, WhatADeviceFailsToDoIsDoneOnTheCpu) {
  using Call = FailingEngine::Call;
  for (const auto& [call, at] :
       {std::pair{Call::kScore, 3}, {Call::kSetImage, 2}, {Call::kAddCell, 5}, {Call::kScore, 1}}) {
    std::vector<std::string> warnings;
    const DeviceBackend device("test", std::make_unique<FailingEngine>(call, at),
                               map_.sharedVisibility(),
                               [&](const std::string& line) { warnings.push_back(line); });
    const CpuBackend cpu(map_.sharedVisibility());
    for (uint64_t frame = 1; frame <= 5; ++frame) {
      const auto image = prepare();
      const std::vector<Pose> poses = cloud(100, frame);
      const auto a = device.evaluate(image->frame, poses), b = cpu.evaluate(image->frame, poses);
      for (size_t i = 0; i < poses.size(); ++i)
        if (warnings.empty())
          ASSERT_NEAR(a[i].log_likelihood, b[i].log_likelihood, 1e-3);
        else
          ASSERT_EQ(a[i].log_likelihood, b[i].log_likelihood);
    }
    ASSERT_EQ(warnings.size(), 1u);
    EXPECT_EQ(warnings[0], "device lost; continuing on the CPU");
    EXPECT_EQ(device.name(), cpu.name());
  }
}

TEST_F(DeviceBackendTest, TheFilterKeepsTrackingWhenTheDeviceIsLost) {
  int warnings = 0;
  map_.setBackend(std::make_unique<DeviceBackend>(
      "test", std::make_unique<FailingEngine>(FailingEngine::Call::kScore, 4),
      map_.sharedVisibility(), [&](const std::string&) { ++warnings; }));
  PoseFilter filter(map_.params().filter, map_.params().refinement);
  filter.initialize(kView, 0.05, 0.03);
  for (int i = 0; i < 4; ++i) {
    filter.predictWithOdometry(Pose::Identity(), 0.1);
    filter.update(map_, {{prepare()}});
  }
  EXPECT_EQ(warnings, 1);
  EXPECT_LT((filter.estimate().mean.translation() - kView.translation()).norm(), 0.03);
}

TEST_F(DeviceBackendTest, ManyThreadsTakeTurns) {
  std::atomic<int> warnings{0};
  const DeviceBackend device("test",
                             std::make_unique<FailingEngine>(FailingEngine::Call::kScore, 10),
                             map_.sharedVisibility(), [&](const std::string&) { ++warnings; });
  const CpuBackend cpu(map_.sharedVisibility());
  const auto image = prepare();
  const std::vector<Pose> poses = cloud(30, 4);
  const auto expected = cpu.evaluate(image->frame, poses);
  std::vector<std::thread> threads;
  threads.reserve(4);
  for (int t = 0; t < 4; ++t)
    threads.emplace_back([&] {
      for (int k = 0; k < 8; ++k) {
        const auto scores = device.evaluate(image->frame, poses);
        for (size_t i = 0; i < poses.size(); ++i)
          EXPECT_NEAR(scores[i].log_likelihood, expected[i].log_likelihood, 1e-3);
      }
    });
  for (std::thread& t : threads) t.join();
  EXPECT_EQ(warnings, 1);
}

}  // namespace
}  // namespace edge_mcl
