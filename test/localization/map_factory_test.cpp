#include "edge_mcl/localization/map_factory.h"

#include <gtest/gtest.h>

#include <fstream>
#include <memory>
#include <string>
#include <utility>

#include "support/error_text.h"
#include "support/scenes.h"
#include "support/temporary_folder.h"

namespace edge_mcl {
namespace {

/// A backend of a device that exists only in this test.
class FakeDevice : public LikelihoodBackend {
 public:
  explicit FakeDevice(std::shared_ptr<const Visibility> visibility)
      : visibility_(std::move(visibility)) {}
  std::vector<PoseScore> evaluate(const LikelihoodFrame&,
                                  const std::vector<Pose>& poses) const override {
    return std::vector<PoseScore>(poses.size());
  }
  std::string name() const override { return "fake device"; }
  const Visibility* visibility() const { return visibility_.get(); }

 private:
  std::shared_ptr<const Visibility> visibility_;
};

LocalizationMap mapWith(BackendChoice choice) {
  Parameters params;
  params.likelihood.backend = choice;
  return {test::furnishedRooms(), params};
}

/// @return what chooseBackend() writes to standard error
std::string warningOf(LocalizationMap* map, const DeviceFactory& make_device) {
  testing::internal::CaptureStderr();
  chooseBackend(map, make_device);
  return testing::internal::GetCapturedStderr();
}

const DeviceFactory kFake = [](auto visibility) {
  return std::make_unique<FakeDevice>(std::move(visibility));
};
const DeviceFactory kNone = [](const auto&) -> std::unique_ptr<LikelihoodBackend> {
  throw NoDevice("no device answers");
};
const DeviceFactory kBusy = [](const auto&) -> std::unique_ptr<LikelihoodBackend> {
  throw Error("all CUDA-capable devices are busy");
};

/// With `auto` the CPU is used instead of a busy device. With `cuda` a busy device is an error.
TEST(BackendChoice, ADeviceThatCannotBeHadIsNoReasonToStop) {
  const DeviceFactory busy = [](const auto&) -> std::unique_ptr<LikelihoodBackend> {
    throw Error("all CUDA-capable devices are busy");
  };
  Parameters params;
  params.likelihood.backend = BackendChoice::kAuto;
  LocalizationMap map(test::furnishedRooms(), params);
  const std::string before = map.backend().name();
  chooseBackend(&map, busy);
  EXPECT_EQ(map.backend().name(), before);
  params.likelihood.backend = BackendChoice::kCuda;
  LocalizationMap wanted(test::furnishedRooms(), params);
  try {
    chooseBackend(&wanted, busy);
    FAIL() << "no error";
  } catch (const ParameterError& e) {
    EXPECT_NE(std::string(e.what()).find("busy"), std::string::npos);
  }
}

TEST(BackendChoice, ADeviceIsTakenByAutoAndByCuda) {
  for (const BackendChoice choice : {BackendChoice::kAuto, BackendChoice::kCuda}) {
    LocalizationMap map = mapWith(choice);
    EXPECT_EQ(warningOf(&map, kFake), "");
    EXPECT_EQ(map.backend().name(), "fake device");
    EXPECT_EQ(dynamic_cast<const FakeDevice&>(map.backend()).visibility(), &map.visibility());
  }
}

TEST(BackendChoice, WithCpuNoDeviceIsAskedFor) {
  LocalizationMap map = mapWith(BackendChoice::kCpu);
  const std::string before = map.backend().name();
  EXPECT_EQ(warningOf(&map, kFake), "");
  EXPECT_EQ(map.backend().name(), before);
}

/// A computer without a device is not a fault. A device that cannot be used is reported.
TEST(BackendChoice, OnlyADeviceThatExistsIsReported) {
  LocalizationMap map = mapWith(BackendChoice::kAuto);
  const std::string before = map.backend().name();
  EXPECT_EQ(warningOf(&map, kNone), "");
  const std::string warning = warningOf(&map, kBusy);
  EXPECT_PRED2(test::contains, warning, "all CUDA-capable devices are busy");
  EXPECT_PRED2(test::contains, warning, "CPU used");
  EXPECT_EQ(map.backend().name(), before);
}

TEST(BackendChoice, CudaWithoutADeviceIsAnErrorThatSaysWhy) {
  LocalizationMap map = mapWith(BackendChoice::kCuda);
  test::expectError<ParameterError>("likelihood.backend cuda: no device answers",
                                    [&] { chooseBackend(&map, kNone); });
}

/// This holds with and without CUDA in the build, and with and without a device.
TEST(DeviceBackend, IsMadeOrItsAbsenceIsExplained) {
  const LocalizationMap map = mapWith(BackendChoice::kCpu);
  try {
    EXPECT_NE(makeDeviceBackend(map.sharedVisibility()), nullptr);
  } catch (const NoDevice& e) {
    EXPECT_STRNE(e.what(), "");
  }
}

class MakeMap : public test::WithFolder {
 protected:
  /// A box of 4 x 3 x 2 m.
  std::string boxFile() const {
    std::ofstream(path("box.obj"))
        << "v 0 0 0\nv 4 0 0\nv 4 3 0\nv 0 3 0\nv 0 0 2\nv 4 0 2\nv 4 3 2\nv 0 3 2\n"
           "f 1 2 3 4\nf 8 7 6 5\nf 5 6 2 1\nf 6 7 3 2\nf 7 8 4 3\nf 8 5 1 4\n";
    return path("box.obj");
  }
};

/// The truth is counted by hand: a box has twelve edges.
TEST_F(MakeMap, LoadsTheModelWithTheParameters) {
  Parameters params;
  params.likelihood.backend = BackendChoice::kCpu;
  params.likelihood.sigma = 3.5;
  params.map.scale = 2;
  const auto map = makeMap(boxFile(), params);
  EXPECT_EQ(map->params().likelihood.sigma, 3.5);
  EXPECT_EQ(map->edges().lines.size(), 12u);
  EXPECT_LT((map->mesh().highest - Eigen::Vector3f(8, 6, 4)).norm(), 1e-5);
}

TEST_F(MakeMap, AModelThatCannotBeReadIsAnError) {
  test::expectError<InputError>("missing.obj", [&] { makeMap(path("missing.obj"), {}); });
}

TEST_F(MakeMap, AnIllegalParameterIsAnError) {
  Parameters params;
  params.likelihood.sigma = -1;
  test::expectError<ParameterError>("likelihood.sigma", [&] { makeMap(boxFile(), params); });
}

}  // namespace
}  // namespace edge_mcl
