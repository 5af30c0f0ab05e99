#include <gtest/gtest.h>
#include <sys/stat.h>
#include <tbb/global_control.h>

#include <filesystem>
#include <fstream>
#include <random>

#include "edge_mcl/core/closest_point.h"
#include "edge_mcl/core/depth_likelihood.h"
#include "edge_mcl/core/error.h"
#include "edge_mcl/core/localization_map.h"
#include "support/scenes.h"

namespace edge_mcl {
namespace {

using Random = std::mt19937_64;

double uniform(Random* random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(*random);
}

Eigen::Vector3d anywhere(Random* random, double low = -1, double high = 1) {
  return {uniform(random, low, high), uniform(random, low, high), uniform(random, low, high)};
}

/// Distance from every face, one by one.
double plainDistance(const MeshModel& mesh, const Eigen::Vector3d& p) {
  double least = INFINITY;
  for (const auto& t : mesh.triangles)
    least = std::min(least, (closestPointOnTriangle(p, mesh.vertices[t[0]].cast<double>(),
                                                    mesh.vertices[t[1]].cast<double>(),
                                                    mesh.vertices[t[2]].cast<double>()) -
                             p)
                                .norm());
  return least;
}

const Pose kView = test::lookAlong({3.2, 2.5, 1.4}, {-1, -0.5, -0.15});

DepthImage roomDepth(const Pose& view = kView) {
  DepthImage image;
  image.camera = test::pinhole(160, 120, 125);
  image.depth = test::renderDepth(test::furnishedRooms(), image.camera, view);
  image.origin = "room";
  return image;
}

std::shared_ptr<const DistanceField> roomField() {
  static const auto field =
      std::make_shared<const DistanceField>(test::furnishedRooms(), DistanceField::Options());
  return field;
}

Pose disturbed(Random* random, double position, double angle) {
  Twist xi;
  xi << position * anywhere(random), angle * anywhere(random);
  return kView * expSe3(xi);
}

TEST(ClosestPoint, NoPointOfTheTriangleIsCloser) {
  Random random(1);
  for (int i = 0; i < 300; ++i) {
    const Eigen::Vector3d a = anywhere(&random), b = anywhere(&random), c = anywhere(&random),
                          p = anywhere(&random, -2, 2);
    const Eigen::Vector3d closest = closestPointOnTriangle(p, a, b, c);
    constexpr int kGrid = 60;
    double least = INFINITY;
    for (int u = 0; u <= kGrid; ++u)
      for (int v = 0; u + v <= kGrid; ++v)
        least = std::min(least, (a + (b - a) * u / kGrid + (c - a) * v / kGrid - p).norm());
    // Some point of the grid is within a grid step of the closest one.
    const double step = ((b - a).norm() + (c - a).norm()) / kGrid;
    EXPECT_LE((closest - p).norm(), least + 1e-12);
    EXPECT_GE((closest - p).norm(), least - step);
  }
}

TEST(ClosestFace, IsTheOneThatBruteForceFinds) {
  const MeshModel mesh = test::furnishedRooms();
  const ClosestFace faces(mesh);
  Random random(2);
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Vector3d p(uniform(&random, -1, 9), uniform(&random, -1, 6),
                            uniform(&random, -1, 3.6));
    const double truth = plainDistance(mesh, p);
    const ClosestFace::Hit hit = faces.find(p, 0.5);
    // The search runs in single precision, so at its very border it may go either way.
    if (std::abs(truth - 0.5) > 1e-5) {
      EXPECT_EQ(hit.found, truth < 0.5);
    }
    if (hit.found) {
      EXPECT_NEAR(hit.distance, truth, 1e-6);
    }
  }
}

TEST(DistanceField, ReadsTheTrueDistance) {
  const MeshModel mesh = test::furnishedRooms();
  const auto field = roomField();
  const double voxel = field->voxelSize(), step = (0.3 + voxel) / 254;
  Random random(3);
  std::vector<double> errors;
  for (int i = 0; i < 20000; ++i) {
    const Eigen::Vector3d p(uniform(&random, -0.5, 8.5), uniform(&random, -0.5, 5.5),
                            uniform(&random, -0.5, 3.1));
    const double truth = plainDistance(mesh, p);
    const DistanceField::Reading reading = field->at(p);
    // A reading is made at a voxel's centre, at most half a diagonal away.
    const double half_diagonal = std::sqrt(3.0) / 2 * voxel;
    if (truth < 0.3 + voxel - half_diagonal) {
      ASSERT_TRUE(reading.near) << truth;
    }
    if (truth > 0.3 + voxel + half_diagonal) {
      ASSERT_FALSE(reading.near) << truth;
    }
    if (!reading.near) continue;
    // Distance and its linear continuation both change by at most a metre per metre.
    EXPECT_LE(std::abs(std::abs(reading.distance) - truth), 2 * half_diagonal + 2 * step);
    errors.push_back(std::abs(std::abs(reading.distance) - truth));
  }
  ASSERT_GT(errors.size(), 5000u);
  // Beside planes, which is nearly everywhere, only rounding is left: half a step of the distance,
  // and of the gradient's three parts half a 127th over half a voxel.
  std::sort(errors.begin(), errors.end());
  const double rounding = step / 2 + 3 * voxel / 2 / 254;
  EXPECT_LT(errors[errors.size() / 2], rounding);
  EXPECT_LT(errors[errors.size() * 8 / 10], 1.01 * rounding);
}

TEST(DistanceField, HasNoHolesFarFromTheOrigin) {
  // A wall of many small faces, where single precision is coarse.
  for (const float at : {40.0f, 1000.0f}) {
    MeshSoup soup;
    constexpr int kCells = 40;
    for (int z = 0; z <= kCells; ++z)
      for (int y = 0; y <= kCells; ++y)
        soup.vertices.emplace_back(at, at + 0.05f * static_cast<float>(y),
                                   0.05f * static_cast<float>(z));
    for (uint32_t z = 0; z < kCells; ++z)
      for (uint32_t y = 0; y < kCells; ++y) {
        const uint32_t corner = z * (kCells + 1) + y, above = corner + kCells + 1;
        soup.triangles.push_back({corner, corner + 1, above});
        soup.triangles.push_back({above, corner + 1, above + 1});
      }
    soup.triangle_material.assign(soup.triangles.size(), 0);
    const DistanceField field(weldMesh(std::move(soup), 1e-4, "wall"), DistanceField::Options());
    Random random(11);
    for (int i = 0; i < 5000; ++i) {
      const double away = uniform(&random, -0.3, 0.3);
      const DistanceField::Reading reading = field.at(
          {static_cast<double>(at) + away, static_cast<double>(at) + uniform(&random, 0.3, 1.7),
           uniform(&random, 0.3, 1.7)});
      ASSERT_TRUE(reading.near) << at << " " << away;
      EXPECT_NEAR(std::abs(reading.distance), std::abs(away), 0.002);
    }
  }
}

TEST(DistanceField, OutsideAndNotFiniteIsFar) {
  EXPECT_FALSE(roomField()->at({100, 0, 0}).near);
  EXPECT_FALSE(roomField()->at({-100, 2, 1}).near);
  EXPECT_FALSE(roomField()->at({NAN, 2, 1}).near);
  EXPECT_FALSE(roomField()->at({4, 2.5, INFINITY}).near);
}

TEST(DistanceField, ALargeModelGetsLargerVoxelsNotMoreMemory) {
  MeshSoup soup;
  test::addBox(&soup, {0, 0, 0}, {900, 700, 300}, 0, true);
  const DistanceField field(weldMesh(std::move(soup), 1e-3, "hangar"), {0.3, 0, 4e6});
  EXPECT_LE(field.size(), 8e6);  // bricks and the grid that finds them, each
  EXPECT_GT(field.voxelSize(), 0.04);
  EXPECT_TRUE(field.at({450, 350, 0.2}).near);
  EXPECT_NEAR(std::abs(field.at({450, 350, 0.2}).distance), 0.2, 0.01);
}

TEST(DistanceField, AModelWithoutFacesIsAnError) {
  MeshSoup soup;
  soup.vertices = {{0, 0, 0}, {1, 0, 0}};
  soup.lines = {{0, 1}};
  const MeshModel lines = weldMesh(std::move(soup), 1e-6, "lines");
  EXPECT_THROW(DistanceField(lines, {}), InputError);
  Parameters params;
  params.likelihood.cues = Cues::kBoth;
  EXPECT_THROW(LocalizationMap(lines, params), InputError);
}

class StoredField : public testing::Test {
 protected:
  void SetUp() override {
    directory_ = testing::TempDir() + "stored_field_" + std::to_string(getpid());
    std::filesystem::create_directories(directory_ + "/model");
    setenv("XDG_CACHE_HOME", (directory_ + "/cache").c_str(), 1);
  }
  void TearDown() override {
    unsetenv("XDG_CACHE_HOME");
    std::filesystem::remove_all(directory_);
  }
  std::vector<std::string> files() const {
    std::vector<std::string> names;
    for (const auto& f : std::filesystem::recursive_directory_iterator(directory_))
      if (f.is_regular_file()) names.push_back(f.path().string());
    return names;
  }
  std::string directory_, warning_;
  MeshModel mesh_ = test::furnishedRooms();
  DistanceField::Options coarse_{0.3, 0.1, 256e6};
};

TEST_F(StoredField, ComesBackAsItWas) {
  const std::string model = directory_ + "/model/rooms.obj";
  const DistanceField made = storedDistanceField(mesh_, coarse_, model, &warning_);
  ASSERT_EQ(files().size(), 1u);
  EXPECT_EQ(files()[0].rfind(model + ".", 0), 0u) << files()[0];
  const auto time = std::filesystem::last_write_time(files()[0]);
  const DistanceField read = storedDistanceField(mesh_, coarse_, model, &warning_);
  EXPECT_EQ(std::filesystem::last_write_time(files()[0]), time);
  Random random(4);
  for (int i = 0; i < 1000; ++i) {
    const Eigen::Vector3d p = anywhere(&random, 0, 5);
    EXPECT_EQ(made.at(p).near, read.at(p).near);
    EXPECT_EQ(made.at(p).distance, read.at(p).distance);
  }
  // Another truncation or another mesh is another field.
  storedDistanceField(mesh_, {0.2, 0.1, 256e6}, model, &warning_);
  mesh_.vertices[0].x() -= 0.01f;
  storedDistanceField(mesh_, coarse_, model, &warning_);
  EXPECT_EQ(files().size(), 3u);
  EXPECT_EQ(warning_, "");
}

TEST_F(StoredField, ADamagedFileIsMadeAnew) {
  const std::string model = directory_ + "/model/rooms.obj";
  const DistanceField made = storedDistanceField(mesh_, coarse_, model, &warning_);
  const std::string file = files().at(0);
  const uint64_t hash = DistanceField::hashOf(mesh_, coarse_);
  const auto size = std::filesystem::file_size(file);
  EXPECT_THROW(DistanceField::read(file, hash + 1), InputError);
  for (const size_t length : {size - 1, size / 2, size_t{60}, size_t{0}}) {
    std::filesystem::resize_file(file, length);
    EXPECT_THROW(DistanceField::read(file, hash), InputError) << length;
    storedDistanceField(mesh_, coarse_, model, &warning_);
    EXPECT_EQ(std::filesystem::file_size(file), size);
  }
  for (const int at : {50, 75, 85, 5000}) {  // origin, truncation, bricks, voxels
    std::fstream(file, std::ios::in | std::ios::out | std::ios::binary).seekp(at).put('\x55');
    EXPECT_THROW(DistanceField::read(file, hash), InputError) << at;
    std::filesystem::remove(file);
    storedDistanceField(mesh_, coarse_, model, &warning_);
  }
}

TEST_F(StoredField, GoesToTheCacheOrNowhere) {
  // No directory of that name: as good as one that cannot be written, which root can.
  const std::string blocked = directory_ + "/file";
  std::ofstream(blocked).put('x');
  storedDistanceField(mesh_, coarse_, blocked + "/rooms.obj", &warning_);
  EXPECT_EQ(warning_, "");
  ASSERT_EQ(files().size(), 2u);
  setenv("XDG_CACHE_HOME", (blocked + "/cache").c_str(), 1);
  storedDistanceField(mesh_, coarse_, blocked + "/rooms.obj", &warning_);
  EXPECT_NE(warning_.find("computed at every start"), std::string::npos);
}

TEST(DepthPoints, ProjectBackToTheirPixels) {
  for (const DistortionModel model :
       {DistortionModel::kNone, DistortionModel::kPlumbBob, DistortionModel::kRationalPolynomial,
        DistortionModel::kEquidistant}) {
    DepthImage image;
    image.camera = test::distorted(test::pinhole(), model);
    image.depth = cv::Mat(480, 640, CV_16U);
    for (int y = 0; y < 480; ++y)
      for (int x = 0; x < 640; ++x) image.depth.at<uint16_t>(y, x) = 1000 + 4 * x + y;
    const DepthPoints points = makeDepthPoints(image, DepthParameters());
    ASSERT_GT(points.count, 400u);
    EXPECT_LE(points.count, 500u);
    for (size_t i = 0; i < points.count; ++i) {
      Eigen::Vector2d pixel;
      ASSERT_TRUE(image.camera.project({points.x[i], points.y[i], points.z[i]}, &pixel));
      const int x = static_cast<int>(std::lround(pixel.x())),
                y = static_cast<int>(std::lround(pixel.y()));
      EXPECT_NEAR(pixel.x(), x, 1e-3);
      EXPECT_NEAR(pixel.y(), y, 1e-3);
      EXPECT_NEAR(points.z[i], image.depth.at<uint16_t>(y, x) / 1000.0, 1e-6);
    }
  }
}

TEST(DepthPoints, WhatIsIgnoredOutOfRangeOrMissingIsLeftOut) {
  DepthImage image = roomDepth();
  DepthParameters params;
  params.max_range = 2.5;
  image.depth.colRange(0, 40).setTo(NAN);
  image.depth.rowRange(0, 10).setTo(-1);
  image.depth.rowRange(10, 15).setTo(INFINITY);
  image.mask = {cv::Mat::zeros(120, 160, CV_8U), image.camera, Pose::Identity()};
  image.mask->pixels.colRange(100, 160).setTo(255);
  const DepthPoints points = makeDepthPoints(image, params);
  ASSERT_GT(points.count, 20u);
  for (size_t i = 0; i < points.count; ++i) {
    Eigen::Vector2d pixel;
    ASSERT_TRUE(image.camera.project({points.x[i], points.y[i], points.z[i]}, &pixel));
    EXPECT_GT(pixel.x(), 39.5);
    EXPECT_LT(pixel.x(), 99.5);
    EXPECT_GT(pixel.y(), 14.5);
    EXPECT_LE(points.z[i], 2.5f);
  }
  image.mask->pixels.setTo(1);
  EXPECT_EQ(makeDepthPoints(image, params).count, 0u);
  image.mask.reset();
  image.depth.setTo(0);
  EXPECT_EQ(makeDepthPoints(image, params).count, 0u);
}

TEST(DepthPoints, TheMaskMayBeThatOfAnotherCamera) {
  DepthImage image = roomDepth();
  // A colour camera 30 cm to the right; what it masks is a half-space of the scene.
  const Eigen::Vector3d offset(0.3, 0, 0);
  DepthImage::Mask mask{cv::Mat::zeros(480, 640, CV_8U), test::pinhole(), Pose::Identity()};
  mask.T_mask_depth.translation() = -offset;
  mask.pixels.colRange(320, 640).setTo(1);
  image.mask = mask;
  const DepthPoints points = makeDepthPoints(image, DepthParameters());
  ASSERT_GT(points.count, 50u);
  for (size_t i = 0; i < points.count; ++i) {
    Eigen::Vector2d pixel;
    const Eigen::Vector3d seen = Eigen::Vector3d(points.x[i], points.y[i], points.z[i]) - offset;
    if (mask.camera.project(seen, &pixel) && mask.camera.contains(pixel)) {
      EXPECT_LT(pixel.x(), 319.6);
    }
  }
}

TEST(DepthPoints, BrokenImagesAreErrors) {
  DepthImage image = roomDepth();
  image.camera.width = 150;
  EXPECT_THROW(makeDepthPoints(image, DepthParameters()), InputError);
  image = roomDepth();
  image.depth.convertTo(image.depth, CV_8U);
  EXPECT_THROW(makeDepthPoints(image, DepthParameters()), InputError);
  image = roomDepth();
  image.mask = {cv::Mat::zeros(12, 16, CV_8U), image.camera, Pose::Identity()};
  EXPECT_THROW(makeDepthPoints(image, DepthParameters()), InputError);
}

TEST(DepthLikelihood, AgreesWithTheFormulaOnTrueDistances) {
  // The scores of points beside planes; a fifth of the field is near edges, where the linear
  // continuation is off by up to some centimetres (see ReadsTheTrueDistance).
  const MeshModel mesh = test::furnishedRooms();
  const DepthParameters params;
  const DepthLikelihood likelihood(roomField(), params);
  const DepthPoints points = makeDepthPoints(roomDepth(), params);
  Random random(5);
  for (int k = 0; k < 20; ++k) {
    const Pose pose = disturbed(&random, 0.03, 0.01);
    double sum = 0;
    for (size_t i = 0; i < points.count; ++i) {
      const double d =
          plainDistance(mesh, pose * Eigen::Vector3d(points.x[i], points.y[i], points.z[i]));
      const double noise = params.sigma_per_square_metre * points.z[i] * points.z[i];
      const double sigma = std::sqrt(params.sigma * params.sigma + noise * noise);
      sum +=
          std::log(params.clutter + (1 - params.clutter) * params.truncation * std::sqrt(2 / M_PI) /
                                        sigma * std::exp(-d * d / (2 * sigma * sigma)));
    }
    const double expected =
        params.independent_points * points.returned * sum / static_cast<double>(points.count);
    EXPECT_NEAR(likelihood.evaluate(points, {pose}).front().log_likelihood, expected,
                0.02 * std::abs(expected) + 1);
  }
}

TEST(DepthLikelihood, VectorUnitAndSlowReferenceAgree) {
  const DepthLikelihood likelihood(roomField(), DepthParameters());
  const DepthPoints points = makeDepthPoints(roomDepth(), DepthParameters());
  Random random(6);
  std::vector<Pose> poses;
  poses.reserve(501);
  for (int i = 0; i < 500; ++i) poses.push_back(disturbed(&random, 0.3, 0.2));
  poses.push_back(test::lookAlong({50, 50, 50}, {1, 0, 0}));  // everything outside
  const std::vector<DepthScore> scores = likelihood.evaluate(points, poses);
  for (size_t i = 0; i < poses.size(); ++i) {
    const DepthScore slow = likelihood.evaluateSlowly(points, poses[i]);
    // Single precision; a point within rounding of a voxel's border may read its neighbour, which
    // near an edge differs by centimetres: one such point may shift the mean of 500.
    EXPECT_NEAR(scores[i].log_likelihood, slow.log_likelihood, 0.4);
    EXPECT_NEAR(scores[i].agreement, slow.agreement, 0.003);
  }
}

TEST(DepthLikelihood, SameBitsAloneInABatchAndOnAnyNumberOfThreads) {
  const DepthLikelihood likelihood(roomField(), DepthParameters());
  const DepthPoints points = makeDepthPoints(roomDepth(), DepthParameters());
  Random random(7);
  std::vector<Pose> poses;
  poses.reserve(333);
  for (int i = 0; i < 333; ++i) poses.push_back(disturbed(&random, 0.2, 0.1));
  const std::vector<DepthScore> all = likelihood.evaluate(points, poses);
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
  const std::vector<DepthScore> again = likelihood.evaluate(points, poses);
  for (size_t i = 0; i < poses.size(); ++i) {
    EXPECT_EQ(all[i].log_likelihood, again[i].log_likelihood);
    EXPECT_EQ(likelihood.evaluate(points, {poses[i]}).front().log_likelihood,
              all[i].log_likelihood);
  }
}

TEST(DepthLikelihood, NothingSaysNothingAndNaNIsAnError) {
  const DepthLikelihood likelihood(roomField(), DepthParameters());
  EXPECT_EQ(likelihood.evaluate(DepthPoints(), {kView}).front().log_likelihood, 0);
  Pose bad = kView;
  bad.translation().x() = NAN;
  EXPECT_THROW(likelihood.evaluate(DepthPoints(), {bad}), Error);
}

TEST(DepthLikelihood, GradientIsTheDerivative) {
  const DepthLikelihood likelihood(roomField(), DepthParameters());
  const DepthPoints points = makeDepthPoints(roomDepth(), DepthParameters());
  Random random(8);
  for (int k = 0; k < 10; ++k) {
    const Pose pose = disturbed(&random, 0.05, 0.03);
    const NormalEquations n = likelihood.linearize(points, pose, 0);
    for (int axis = 0; axis < 6; ++axis) {
      // Short, so that hardly any point changes its voxel.
      constexpr double kStep = 1e-7;
      const Twist xi = kStep * Twist::Unit(axis);
      const double numeric =
          (likelihood.evaluateSlowly(points, pose * expSe3(xi)).log_likelihood -
           likelihood.evaluateSlowly(points, pose * expSe3(-xi)).log_likelihood) /
          (2 * kStep);
      EXPECT_NEAR(n.g[axis], numeric, 1e-3 * n.g.norm() + 1e-3) << axis;
    }
  }
}

TEST(DepthLikelihood, ABiasIsFoundFromDepthsNearAndFar) {
  const DepthLikelihood likelihood(roomField(), DepthParameters());
  for (const double b : {-0.003, 0.0015, 0.004}) {
    DepthImage image = roomDepth();
    for (int y = 0; y < image.depth.rows; ++y)
      for (int x = 0; x < image.depth.cols; ++x) {
        float& z = image.depth.at<float>(y, x);
        z -= static_cast<float>(b) * z * z;
      }
    DepthBias bias{0, 0.004 * 0.004};
    const DepthPoints points = makeDepthPoints(image, DepthParameters());
    for (int i = 0; i < 5; ++i) {
      const DepthPoints better = withoutBias(points, bias);
      const DepthBias rest = likelihood.remainingBias(better, kView, 1e-6 * Matrix6::Identity());
      bias.mean += rest.mean;
      EXPECT_LT(rest.variance, bias.variance);
    }
    EXPECT_NEAR(bias.mean, b, 3e-4) << b;
  }
}

TEST(DepthLikelihood, RefinementFindsTheTruePose) {
  Parameters params;
  params.likelihood.cues = Cues::kDepth;
  params.depth.bias_sigma = 0;
  const LocalizationMap map(test::furnishedRooms(), params);
  CameraView view;
  view.depth = map.prepareDepth(roomDepth());
  view.T_base_camera = opticalOnBody();  // the state is the base's pose
  const Pose truth = kView * view.T_base_camera.inverse();
  Random random(9);
  for (int seed = 0; seed < 50; ++seed) {
    PoseGaussian prior;
    Twist xi;
    xi << 0.1 * anywhere(&random), 0.05 * anywhere(&random);
    prior.mean = truth * expSe3(xi);
    prior.covariance.diagonal() << 1, 1, 1, 0.25, 0.25, 0.25;  // wide: it must not pull
    const RefinementResult result = map.refine({view}, prior.mean, prior);
    EXPECT_GT(result.matched_points, 300);
    // Exact depths: what is left is the field's rounding (0.7 mm), averaged over many points.
    EXPECT_LT((result.pose.translation() - truth.translation()).norm(), 0.0005) << seed;
    EXPECT_LT(logSo3(truth.linear().transpose() * result.pose.linear()).norm(), 0.0005) << seed;
  }
}

}  // namespace
}  // namespace edge_mcl
