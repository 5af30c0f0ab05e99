#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <numeric>

#include "edge_mcl/core/base/random_source.h"
#include "edge_mcl/core/localization_map.h"
#include "edge_mcl/gpu/backend/conversion.h"
#include "edge_mcl/gpu/backend/workload_export.h"
#include "edge_mcl/gpu/emulation/host_emulation.h"
#include "edge_mcl/gpu/emulation/table_emulation.h"
#include "support/scenes.h"

#ifdef EDGE_MCL_HAS_CUDA
#include "edge_mcl/gpu/backend/cuda_backend.h"
#endif

namespace edge_mcl {
namespace {

enum class Scene { kRoomMesh, kLineMap, kFisheye };

struct Case {
  Scene scene;
  LikelihoodModel model;
};

const Pose kView = test::lookAlong({3.2, 2.5, 1.4}, {-1, -0.5, -0.15});

/// The edges of the furnished rooms as a line map without faces.
MeshModel lineMap() {
  const MeshModel rooms = test::furnishedRooms();
  MeshModel mesh = rooms;
  const EdgeModel edges = buildEdgeModel(&mesh, {});
  MeshSoup soup;
  for (const EdgeLine& line : edges.lines) {
    const auto first = static_cast<uint32_t>(soup.vertices.size());
    soup.vertices.push_back(line.start);
    soup.vertices.push_back(line.end);
    soup.lines.push_back({first, first + 1});
  }
  return weldMesh(soup, 1e-6, "line map");
}

std::vector<Pose> cloud(size_t n) {
  RandomSource random(21);
  std::vector<Pose> poses;
  Twist scale;
  scale << 0.15, 0.15, 0.15, 0.1, 0.1, 0.1;
  for (size_t i = 0; i < n; ++i)
    poses.push_back(kView * expSe3(scale.cwiseProduct(random.normalTwist())));
  return poses;
}

/// The frame of the case, 10,000 poses, and their scores by the CPU backend.
class Parity : public testing::TestWithParam<Case> {
 protected:
  void SetUp() override {
    Parameters params;
    params.likelihood.model = GetParam().model;
    map_ = std::make_unique<LocalizationMap>(
        GetParam().scene == Scene::kLineMap ? lineMap() : test::furnishedRooms(), params);
    CameraModel camera = test::pinhole(320, 240, 220);
    if (GetParam().scene == Scene::kFisheye) {
      camera.distortion = DistortionModel::kEquidistant;
      camera.coefficients = {0.02, -0.01, 0.003, -0.001};
    }
    camera.validate("test");
    cv::Mat mask(240, 320, CV_8U, cv::Scalar(0));
    mask(cv::Rect(100, 80, 60, 50)) = 255;
    image_ = map_->prepare(
        camera, test::render(test::furnishedRooms(), test::pinhole(320, 240, 220), kView, 1), mask,
        "room");
    poses_ = cloud(10000);
    reference_ = CpuBackend(map_->sharedVisibility()).evaluate(image_->frame, poses_);
  }

  /// Single precision places a sample with an error of about 3e-5 px on host and device. Where the
  /// table steps, a score changes by up to 5 nats per pixel. Lines are discounted, which brings the
  /// total difference below this.
  static constexpr double kTolerance = 1e-3;

  void expectAgreement(const std::vector<double>& values) const {
    ASSERT_EQ(values.size(), reference_.size());
    double largest = 0;
    std::vector<double> truth;
    for (size_t i = 0; i < values.size(); ++i) {
      truth.push_back(reference_[i].log_likelihood);
      ASSERT_TRUE(std::isfinite(values[i]));
      largest = std::max(largest, std::abs(values[i] - truth[i]));
    }
    std::printf("largest difference of %zu log-likelihoods: %.2g\n", values.size(), largest);
    EXPECT_LE(largest, kTolerance);
    const auto ranking = [](const std::vector<double>& v) {
      std::vector<uint32_t> order(v.size());
      std::iota(order.begin(), order.end(), 0u);
      std::stable_sort(order.begin(), order.end(),
                       [&](uint32_t a, uint32_t b) { return v[a] > v[b]; });
      return order;
    };
    const auto expected = ranking(truth), found = ranking(values);
    for (size_t k = 0; k < 100; ++k)  // ties within the tolerance may swap
      EXPECT_LE(std::abs(truth[expected[k]] - truth[found[k]]), 2 * kTolerance) << "rank " << k;
  }

  std::shared_ptr<const Picture> picture() const {
    const Parameters& p = map_->params();
    return std::make_shared<Picture>(image_->edges.grey, image_->edges.ignore, p.image,
                                     std::make_shared<ScoreLevels>(p.image, p.likelihood));
  }

  std::unique_ptr<LocalizationMap> map_;
  std::shared_ptr<const PreparedImage> image_;
  std::vector<Pose> poses_;
  std::vector<PoseScore> reference_;
};

TEST_P(Parity, TheKernelBodyOnTheHostAgreesWithTheCpuBackend) {
  const gpu::Workload workload = gpu::makeWorkload("test", map_->visibility(), image_->frame,
                                                   poses_, reference_, picture().get());
  const std::vector<gpu::Quad> quads = gpu::emulateTable(workload.table, workload.pairs.data());
  for (const int warps : {1, gpu::kParts}) {
    std::vector<double> values;
    for (const gpu::Result& r : gpu::emulate(workload, quads, warps))
      values.push_back(r.log_likelihood);
    expectAgreement(values);
  }
  // For a machine that has a GPU and nothing else, see bench/README.md.
  if (const char* directory = std::getenv("EDGE_MCL_WORKLOADS"))
    gpu::writeWorkload(workload, std::string(directory) + "/parity" +
                                     std::to_string(static_cast<int>(GetParam().scene)) +
                                     std::to_string(static_cast<int>(GetParam().model)));
}

TEST_P(Parity, TheDeviceAgreesWithTheCpuBackend) {
#ifdef EDGE_MCL_HAS_CUDA
  if (const std::string why = whyNoCuda(); !why.empty())
    GTEST_SKIP() << "SKIPPED: no CUDA device answers: " << why;
  std::string warning;
  const auto backend =
      makeCudaBackend(map_->sharedVisibility(), [&](const std::string& w) { warning = w; });
  LikelihoodFrame of_picture = image_->frame;
  of_picture.table = nullptr;
  of_picture.picture = picture();
  for (const LikelihoodFrame& frame : {image_->frame, of_picture}) {
    std::vector<double> values;
    for (const PoseScore& s : backend->evaluate(frame, poses_)) values.push_back(s.log_likelihood);
    EXPECT_EQ(warning, "");
    expectAgreement(values);
  }
#else
  GTEST_SKIP() << "SKIPPED: built without CUDA";
#endif
}

INSTANTIATE_TEST_SUITE_P(All, Parity,
                         testing::Values(Case{Scene::kRoomMesh, LikelihoodModel::kPaper},
                                         Case{Scene::kRoomMesh, LikelihoodModel::kRobust},
                                         Case{Scene::kLineMap, LikelihoodModel::kPaper},
                                         Case{Scene::kLineMap, LikelihoodModel::kRobust},
                                         Case{Scene::kFisheye, LikelihoodModel::kPaper},
                                         Case{Scene::kFisheye, LikelihoodModel::kRobust}));

/// The truth of the maths for host and device is the camera model in double precision.
TEST(SampleMath, ProjectsLikeTheCameraModel) {
  RandomSource random(3);
  for (const auto model : {DistortionModel::kNone, DistortionModel::kPlumbBob,
                           DistortionModel::kRationalPolynomial, DistortionModel::kEquidistant}) {
    CameraModel camera = test::pinhole(320, 240, 220);
    camera.distortion = model;
    if (model == DistortionModel::kPlumbBob) camera.coefficients = {-0.28, 0.07, 2e-4, 2e-5, 0};
    if (model == DistortionModel::kRationalPolynomial)
      camera.coefficients = {0.2, -0.1, 1e-3, -5e-4, 0.01, 0.4, -0.05, 0.02};
    if (model == DistortionModel::kEquidistant) camera.coefficients = {0.02, -0.01, 0.003, -0.001};
    camera.validate("test");
    const gpu::Camera c = gpu::cameraOf(camera);
    for (int i = 0; i < 1000; ++i) {
      const float x = static_cast<float>(1.2 * random.uniform() - 0.6);
      const float y = static_cast<float>(random.uniform() - 0.5), r2 = x * x + y * y;
      Eigen::Vector2d pixel;
      Eigen::Matrix<double, 2, 3> jacobian;
      if (!camera.project({x, y, 1}, &pixel, &jacobian)) continue;
      gpu::Distorted q{x, y, 1, 0, 1};
      if (model == DistortionModel::kEquidistant)
        q = gpu::distortEquidistant(c, x, y, r2);
      else if (model != DistortionModel::kNone)
        q = gpu::distortPolynomial(c, x, y, r2);
      // The tolerance is ten roundings of numbers up to 320.
      EXPECT_NEAR(c.fx * q.x + c.cx, pixel.x(), 2e-4);
      EXPECT_NEAR(c.fy * q.y + c.cy, pixel.y(), 2e-4);
      EXPECT_NEAR(c.fx * q.j00, jacobian(0, 0), 2e-3);
      EXPECT_NEAR(c.fx * q.j01, jacobian(0, 1), 2e-3);
      EXPECT_NEAR(c.fy * q.j11, jacobian(1, 1), 2e-3);
    }
  }
}

TEST(Workload, ADamagedFileIsRefused) {
  const std::string file = testing::TempDir() + "workload";
  gpu::Workload w;
  w.table = {3, 2, 1, 0, 1, 0};
  w.camera.last_x = 2;
  w.camera.last_y = 1;
  w.pairs.assign(13, 257);
  w.chunks.resize(1);
  w.chunks[0].count = 1;
  w.samples.resize(gpu::kLanes);
  w.cells.resize(1);
  w.cells[0].chunk_count = 1;
  for (uint32_t& end : w.cells[0].part_end) end = 1;
  w.particles.resize(1);
  w.reference = {0};
  gpu::writeWorkload(w, file);
  EXPECT_EQ(gpu::readWorkload(file).pairs, w.pairs);
  std::ifstream in(file, std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(in)), {});
  std::ofstream(file, std::ios::binary) << bytes.substr(0, bytes.size() / 2);
  EXPECT_THROW(gpu::readWorkload(file), std::runtime_error);
  w.chunks[0].count = 33;  // a sample that the file does not hold
  gpu::writeWorkload(w, file);
  EXPECT_THROW(gpu::readWorkload(file), std::runtime_error);
  EXPECT_THROW(gpu::readWorkload("/does/not/exist"), std::runtime_error);
}

}  // namespace
}  // namespace edge_mcl
