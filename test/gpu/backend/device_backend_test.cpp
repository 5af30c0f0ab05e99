#include "edge_mcl/gpu/backend/device_backend.h"

#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/localization_map.h"
#include "edge_mcl/gpu/emulation/emulated_engine.h"
#include "edge_mcl/localization/filter/pose_filter.h"
#include "support/scenes.h"

namespace edge_mcl {
namespace {

const Pose kView = test::lookAlong({3.2, 2.5, 1.4}, {-1, -0.5, -0.15});

/// Works until call number `fails_at` of one kind, then throws as a lost device does.
class FailingEngine : public gpu::EmulatedEngine {
 public:
  enum class Call { kScore, kSetPicture, kAddCell };
  FailingEngine(Call call, int fails_at) : call_(call), left_(fails_at) {}
  uint32_t addCell(gpu::Cell cell, const gpu::Chunk* chunks, const gpu::Sample* samples) override {
    count(Call::kAddCell);
    return EmulatedEngine::addCell(cell, chunks, samples);
  }
  void setPicture(int image, const gpu::Camera& camera, const gpu::Table& table,
                  const gpu::TableRecipe& recipe, const gpu::PictureData& picture) override {
    count(Call::kSetPicture);
    EmulatedEngine::setPicture(image, camera, table, recipe, picture);
  }
  void submit(int image, const gpu::Rule& rule, const gpu::Combination& combination, size_t first,
              size_t n) override {
    count(Call::kScore);
    EmulatedEngine::submit(image, rule, combination, first, n);
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

/// The truth is the CPU backend.
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

/// When the device is lost, this frame is computed anew on the CPU. One line is reported. All later
/// frames are equal to the CPU backend to the last bit.
TEST_F(DeviceBackendTest, WhatADeviceFailsToDoIsDoneOnTheCpu) {
  using Call = FailingEngine::Call;
  for (const auto& [call, at] : {std::pair{Call::kScore, 3},
                                 {Call::kSetPicture, 2},
                                 {Call::kAddCell, 5},
                                 {Call::kScore, 1}}) {
    std::vector<std::string> warnings;
    map_.setBackend(std::make_unique<DeviceBackend>(
        "test", std::make_unique<FailingEngine>(call, at), map_.sharedVisibility(),
        [&](const std::string& line) { warnings.push_back(line); }));
    const LikelihoodBackend& device = map_.backend();
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

/// With a device the host makes no table. The device uses masks. It can score images that it has
/// already dropped for newer ones.
TEST_F(DeviceBackendTest, MakesTheTablesItself) {
  const CpuBackend cpu(map_.sharedVisibility());
  map_.setBackend(std::make_unique<DeviceBackend>("test", std::make_unique<gpu::EmulatedEngine>(),
                                                  map_.sharedVisibility(),
                                                  [](const std::string& line) { FAIL() << line; }));
  std::vector<std::shared_ptr<const PreparedImage>> images;
  for (int i = 0; i < gpu::ScoringEngine::kImages + 2; ++i) {
    cv::Mat mask(240, 320, CV_8U, cv::Scalar(0));
    mask(cv::Rect(40 * i, 30, 50, 80)) = 255;
    images.push_back(map_.prepare(camera_, picture_, i % 2 ? mask : cv::Mat(), "room"));
    EXPECT_EQ(images.back()->frame.table, nullptr);
  }
  const std::vector<Pose> poses = cloud(40, 7);
  for (int round = 0; round < 2; ++round)
    for (const auto& image : images) {
      const auto a = map_.backend().evaluate(image->frame, poses);
      const auto b = cpu.evaluate(image->frame, poses);
      for (size_t i = 0; i < poses.size(); ++i)
        EXPECT_NEAR(a[i].log_likelihood, b[i].log_likelihood, 1e-3);
    }
}

/// Two frames share a table but have different cameras. Each must be scored with its own camera.
TEST_F(DeviceBackendTest, ATableIsScoredWithTheFramesOwnCamera) {
  const DeviceBackend device("test", std::make_unique<gpu::EmulatedEngine>(),
                             map_.sharedVisibility(), {});
  const CpuBackend cpu(map_.sharedVisibility());
  LikelihoodFrame frame = prepare()->frame;
  const std::vector<Pose> poses = cloud(40, 9);
  device.evaluate(frame, poses);
  frame.camera.fx *= 1.1;
  frame.camera.validate("zoomed");
  const auto a = device.evaluate(frame, poses), b = cpu.evaluate(frame, poses);
  for (size_t i = 0; i < poses.size(); ++i)
    EXPECT_NEAR(a[i].log_likelihood, b[i].log_likelihood, 1e-3);
}

TEST_F(DeviceBackendTest, CamerasOfDifferentSizesTakeTurns) {
  const CpuBackend cpu(map_.sharedVisibility());
  map_.setBackend(std::make_unique<DeviceBackend>("test", std::make_unique<gpu::EmulatedEngine>(),
                                                  map_.sharedVisibility(),
                                                  [](const std::string& line) { FAIL() << line; }));
  const std::vector<Pose> poses = cloud(20, 8);
  for (int round = 0; round < 2; ++round)
    for (int width = 100; width < 200; width += 10) {
      const CameraModel camera = test::pinhole(width, 90, 70);
      const cv::Mat grey = test::render(test::furnishedRooms(), camera, kView, 1);
      const auto image = map_.prepare(camera, grey, {}, "room");
      const auto a = map_.backend().evaluate(image->frame, poses);
      const auto b = cpu.evaluate(image->frame, poses);
      for (size_t i = 0; i < poses.size(); ++i)
        EXPECT_NEAR(a[i].log_likelihood, b[i].log_likelihood, 1e-3);
    }
}

/// More particles than fit into one batch lie in cells that occur first in different batches.
TEST_F(DeviceBackendTest, ManyParticlesInManyCells) {
  const DeviceBackend device("test", std::make_unique<gpu::EmulatedEngine>(),
                             map_.sharedVisibility(), {});
  const CpuBackend cpu(map_.sharedVisibility());
  LikelihoodFrame frame = prepare()->frame;
  frame.thinning = 20;
  std::vector<Pose> poses = cloud(140000, 9);
  for (size_t i = 70000; i < poses.size(); ++i) poses[i].translation().x() -= 0.6;
  const auto a = device.evaluate(frame, poses), b = cpu.evaluate(frame, poses);
  double largest = 0;
  for (size_t i = 0; i < poses.size(); ++i)
    largest = std::max(largest, std::abs(a[i].log_likelihood - b[i].log_likelihood));
  EXPECT_LE(largest, 1e-3);
}

TEST_F(DeviceBackendTest, APoseThatIsNotFiniteIsRefusedAndTheNextFrameIsScored) {
  const DeviceBackend device("test", std::make_unique<gpu::EmulatedEngine>(),
                             map_.sharedVisibility(), {});
  std::vector<Pose> poses = cloud(20, 5);
  poses[7].translation().y() = std::nan("");
  const LikelihoodFrame frame = prepare()->frame;
  EXPECT_THROW(device.evaluate(frame, poses), Error);
  EXPECT_EQ(device.evaluate(frame, cloud(20, 5)).size(), 20u);
}

/// The device is lost at its fourth call.
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

/// Four threads use one device, which is lost at its tenth call. Only one line may be reported.
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
