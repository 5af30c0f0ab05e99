#include <gtest/gtest.h>
#include <mrpt/bayes/CParticleFilter.h>
#include <mrpt/config/CConfigFileMemory.h>
#include <mrpt/io/CMemoryStream.h>
#include <mrpt/maps/CMultiMetricMap.h>
#include <mrpt/obs/CActionRobotMovement3D.h>
#include <mrpt/obs/CObservation3DRangeScan.h>
#include <mrpt/obs/CSensoryFrame.h>
#include <mrpt/opengl/CSetOfObjects.h>
#include <mrpt/serialization/CArchive.h>

#include <fstream>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/localization/filter/resampling.h"
#include "edge_mcl/mrpt_plugins/CEdgeMonteCarloLocalization3D.h"
#include "edge_mcl/mrpt_plugins/CObservationMaskedImage.h"
#include "edge_mcl/mrpt_plugins/mrpt_conversions.h"
#include "edge_mcl/mrpt_plugins/rawlog_export.h"
#include "support/scenes.h"

namespace edge_mcl {
namespace {

/// Writes the furnished rooms to a file. @return its name
std::string roomFile() {
  const std::string file = testing::TempDir() + "rooms.obj";
  const MeshModel mesh = test::furnishedRooms();
  std::ofstream out(file);
  for (const auto& v : mesh.vertices) out << "v " << v.transpose() << "\n";
  for (const auto& t : mesh.triangles)
    out << "f " << t[0] + 1 << " " << t[1] + 1 << " " << t[2] + 1 << "\n";
  return file;
}

const Pose kView = test::lookAlong({3.2, 2.5, 1.4}, {-1, -0.5, -0.15});

CObservationMaskedImage::Ptr roomObservation(const Pose& T_base_camera, const Pose& view = kView) {
  const CameraModel camera = test::pinhole(320, 240, 250);
  auto obs = std::make_shared<CObservationMaskedImage>();
  obs->cameraParams = toMrpt(camera);
  obs->cameraPose = toMrpt(T_base_camera);
  obs->image = mrpt::img::CImage(test::render(test::furnishedRooms(), camera, view, 1),
                                 mrpt::img::DEEP_COPY);
  return obs;
}

TEST(Conversions, PosesAndCamerasRoundTrip) {
  RandomSource random(31);
  for (int i = 0; i < 100; ++i) {
    const Pose pose = expSe3(random.normalTwist());
    EXPECT_LT((toPose(toMrpt(pose)).matrix() - pose.matrix()).norm(), 1e-9);
    EXPECT_LT((toPose(toMrpt(pose).asTPose()).matrix() - pose.matrix()).norm(), 1e-9);
  }
  CameraModel camera = test::pinhole();
  camera.distortion = DistortionModel::kEquidistant;
  camera.coefficients = {0.02, -0.01, 0.003, -0.001};
  camera.validate("x");
  const CameraModel back = toCameraModel(toMrpt(camera), "x");
  EXPECT_EQ(back.coefficients, camera.coefficients);
  EXPECT_EQ(back.distortion, camera.distortion);
}

TEST(Conversions, CovarianceKeepsTheSignOfCrossTerms) {
  // x and yaw have a positive or a negative correlation. The CPose3DPDFParticles of MRPT takes
  // absolute differences of angles and cannot tell the two apart.
  for (const double sign : {1.0, -1.0}) {
    PoseGaussian g;
    Twist d = Twist::Zero();
    d[0] = 0.1;
    d[5] = sign * 0.2;
    g.covariance = d * d.transpose();
    EXPECT_NEAR(toMrptCovariance(g)(0, 3), sign * 0.02, 1e-6);
  }
}

TEST(Observation, SerializesWithItsMask) {
  auto obs = roomObservation(opticalOnBody());
  cv::Mat mask(240, 320, CV_8U, cv::Scalar(0));
  mask(cv::Rect(10, 20, 30, 40)) = 255;
  obs->ignore_mask = mrpt::img::CImage(mask, mrpt::img::DEEP_COPY);
  mrpt::io::CMemoryStream stream;
  auto archive = mrpt::serialization::archiveFrom(stream);
  archive << *obs;
  stream.Seek(0);
  const auto read = std::dynamic_pointer_cast<CObservationMaskedImage>(archive.ReadObject());
  ASSERT_TRUE(read);
  EXPECT_EQ(cv::norm(read->ignore_mask.asCvMatRef(), mask), 0);
  EXPECT_EQ(cv::norm(read->image.asCvMatRef(), obs->image.asCvMatRef()), 0);
}

mrpt::config::CConfigFileMemory iniFor(const std::string& extra) {
  return mrpt::config::CConfigFileMemory(
      "[MetricMap]\nedge_mcl::CEdgeMap_count = 1\n"
      "[MetricMap_edge_mcl::CEdgeMap_00_creationOpts]\nmodel_file = " +
      roomFile() + "\n" + extra);
}

TEST(EdgeMap, AnIniFileCreatesIt) {
  mrpt::maps::TSetOfMetricMapInitializers initializers;
  initializers.loadFromConfigFile(iniFor("likelihood.sigma = 3   # px\n"), "MetricMap");
  mrpt::maps::CMultiMetricMap maps;
  maps.setListOfMaps(initializers);
  ASSERT_EQ(maps.maps.size(), 1u);
  const auto map = std::dynamic_pointer_cast<CEdgeMap>(maps.maps[0]);
  ASSERT_TRUE(map);
  EXPECT_EQ(map->localization().params().likelihood.sigma, 3);
  auto scene = mrpt::opengl::CSetOfObjects::Create();
  map->getVisualizationInto(*scene);
  EXPECT_EQ(scene->size(), 1u);
  mrpt::maps::TSetOfMetricMapInitializers wrong;
  EXPECT_THROW(wrong.loadFromConfigFile(iniFor("likelihood.sgima = 3\n"), "MetricMap"),
               std::exception);
}

TEST(EdgeMap, SerializesAsFileAndParameters) {
  Parameters params;
  params.likelihood.sigma = 3.5;
  const CEdgeMap map(roomFile(), params);
  mrpt::io::CMemoryStream stream;
  auto archive = mrpt::serialization::archiveFrom(stream);
  archive << map;
  stream.Seek(0);
  const auto read = std::dynamic_pointer_cast<CEdgeMap>(archive.ReadObject());
  ASSERT_TRUE(read);
  EXPECT_EQ(read->localization().params().toYaml(), params.toYaml());
}

/// One pose alone must get its score in the batch.
TEST(EdgeMap, TheScalarPathGivesTheBatchsNumbers) {
  const CEdgeMap map(roomFile(), Parameters());
  const auto obs = roomObservation(opticalOnBody());
  RandomSource random(32);
  std::vector<Pose> poses;
  for (int i = 0; i < 50; ++i)
    poses.push_back(kView * opticalOnBody().inverse() * expSe3(0.05 * random.normalTwist()));
  const std::vector<double> batch = map.logLikelihoods(*obs, poses);
  for (size_t i = 0; i < poses.size(); ++i) {
    const double scalar = map.computeObservationLikelihood(*obs, toMrpt(poses[i]));
    EXPECT_TRUE(std::isfinite(scalar));
    EXPECT_EQ(map.logLikelihoods(*obs, {poses[i]}).front(), batch[i]);
    EXPECT_LT((toPose(toMrpt(poses[i])).matrix() - poses[i].matrix()).norm(), 1e-12);
    // CPose3D holds the same rotation matrix. Only the last bits of its entries may differ.
    EXPECT_NEAR(scalar, batch[i], 1e-6 * (1 + std::abs(batch[i])));
  }
}

TEST(EdgeMap, ScoresTheIntensityImageOfARangeScan) {
  const CEdgeMap map(roomFile(), Parameters());
  const auto obs = roomObservation(opticalOnBody());
  mrpt::obs::CObservation3DRangeScan scan;
  EXPECT_FALSE(map.canComputeObservationLikelihood(scan));
  scan.hasIntensityImage = true;
  scan.intensityImage = obs->image;
  scan.cameraParamsIntensity = obs->cameraParams;
  scan.relativePoseIntensityWRTDepth = obs->cameraPose;
  const mrpt::poses::CPose3D base = toMrpt(kView * opticalOnBody().inverse());
  EXPECT_TRUE(map.canComputeObservationLikelihood(scan));
  EXPECT_EQ(map.computeObservationLikelihood(scan, base),
            map.computeObservationLikelihood(*obs, base));
}

/// The truth is the score of the same depths as a depth image.
TEST(EdgeMap, ScoresTheRangeImageOfARangeScan) {
  Parameters params;
  params.likelihood.cues = Cues::kDepth;
  params.depth.store_field = false;
  const CEdgeMap map(roomFile(), params);
  const CameraModel camera = test::pinhole(160, 120, 125);
  const cv::Mat metres = test::renderDepth(test::furnishedRooms(), camera, kView);
  DepthImage image;
  image.camera = camera;
  metres.convertTo(image.depth, CV_16U, 1000);
  CameraView view;
  view.depth = map.localization().prepareDepth(image);
  // The sensor is 20 cm ahead of the base and looks along the x axis of the base.
  const mrpt::poses::CPose3D mounting(0.2, 0, 0, 0, 0, 0);
  const Pose base = kView * opticalOnBody().inverse() * toPose(mounting).inverse();
  const double expected = map.localization().evaluate({view}, {kView}).front().log_likelihood;
  ASSERT_GT(expected, 20);

  mrpt::obs::CObservation3DRangeScan scan;
  scan.sensorPose = mounting;
  scan.cameraParams = toMrpt(camera);
  EXPECT_FALSE(map.canComputeObservationLikelihood(scan));
  scan.hasRangeImage = true;
  scan.rangeUnits = 0.001f;
  scan.range_is_depth = true;
  scan.rangeImage.resize(120, 160);
  for (int y = 0; y < 120; ++y)
    for (int x = 0; x < 160; ++x) scan.rangeImage(y, x) = image.depth.at<uint16_t>(y, x);
  EXPECT_TRUE(map.canComputeObservationLikelihood(scan));
  // The points are equal. The pose is converted differently, which costs some bits.
  EXPECT_NEAR(map.computeObservationLikelihood(scan, toMrpt(base)), expected, 0.05);

  // The same object with another mounting must be scored anew, and not from stored points.
  scan.sensorPose = mrpt::poses::CPose3D(0.2, 0.5, 0, 0, 0, 0);
  EXPECT_LT(map.computeObservationLikelihood(scan, toMrpt(base)), expected - 10);
  scan.sensorPose = mounting;

  // Ranges along the rays in units of 0.5 mm are rounded differently, by a hundredth of the noise.
  scan.range_is_depth = false;
  scan.rangeUnits = 0.0005f;
  for (int y = 0; y < 120; ++y)
    for (int x = 0; x < 160; ++x)
      scan.rangeImage(y, x) = static_cast<uint16_t>(
          std::lround(metres.at<float>(y, x) * test::plainRay(camera, x, y).norm() / 0.0005));
  EXPECT_NEAR(map.computeObservationLikelihood(scan, toMrpt(base)), expected, 0.3);

  scan.rangeImage.resize(10, 10);
  EXPECT_THROW(map.computeObservationLikelihood(scan, toMrpt(base)), std::exception);
  // The parameters use depth only, so an image cannot be scored.
  EXPECT_FALSE(map.canComputeObservationLikelihood(*roomObservation(opticalOnBody())));
}

TEST(EdgeMap, BrokenObservationsAreErrors) {
  const CEdgeMap map(roomFile(), Parameters());
  auto obs = roomObservation(opticalOnBody());
  obs->cameraParams.ncols = 100;
  EXPECT_THROW(map.computeObservationLikelihood(*obs, {}), std::exception);
  CObservationMaskedImage empty;
  empty.cameraParams = toMrpt(test::pinhole());
  EXPECT_THROW(map.computeObservationLikelihood(empty, {}), std::exception);
}

TEST(TiltCorrection, IsTheProductOfGaussians) {
  // Particles are drawn around a tilted pose, and the IMU gives one reading. For small angles the
  // posterior of each axis is known in closed form.
  RandomSource random(41);
  const Pose truth = expSe3((Twist() << 1, 2, 3, 0.2, -0.3, 1.0).finished());
  const double spread = 0.04, sigma = 0.02, offset = 0.05;
  const Eigen::Vector3d axis =
      (truth.linear().transpose() * Eigen::Vector3d::UnitZ()).unitOrthogonal();
  PoseGaussian prior{truth, spread * spread * Matrix6::Identity()};
  // The reading is turned by `offset` from the mean of the particles.
  Pose turned = truth;
  turned.linear() = truth.linear() * expSo3(offset * axis);
  const UpReading reading{turned.linear().transpose() * Eigen::Vector3d::UnitZ(), sigma};
  EXPECT_NEAR((tiltError(truth, reading.up_base) - offset * axis).norm(), 0, 1e-9);

  constexpr int kParticles = 20000;
  std::vector<Pose> poses;
  const GaussianDensity density(prior);
  for (int i = 0; i < kParticles; ++i) poses.push_back(density.draw(&random));
  const std::vector<double> weights(kParticles, 1.0);
  ASSERT_TRUE(correctTilt(reading, weights, &random, &poses));
  const PoseGaussian after = meanAndCovariance(poses, weights),
                     gaussian = correctTilt(reading, prior);
  const double gain = spread * spread / (spread * spread + sigma * sigma);
  const double left = spread * sigma / std::hypot(spread, sigma);  // standard deviation
  for (const PoseGaussian& p : {after, gaussian}) {
    const Eigen::Vector3d shift = logSo3(truth.linear().transpose() * p.mean.linear());
    // The mean of 20000 draws has an error of 1/141 of its spread. Curvature adds the square of the
    // offset.
    EXPECT_NEAR((shift - gain * offset * axis).norm(), 0, 0.0015);
    const Eigen::Matrix3d c = p.covariance.bottomRightCorner<3, 3>();
    EXPECT_NEAR(std::sqrt(axis.dot(c * axis)), left, 0.03 * left);
    const Eigen::Vector3d vertical = p.mean.linear().transpose() * Eigen::Vector3d::UnitZ();
    // The yaw does not change.
    EXPECT_NEAR(std::sqrt(vertical.dot(c * vertical)), spread, 0.03 * spread);
    EXPECT_NEAR(p.covariance(0, 0), spread * spread, 0.04 * spread * spread);
  }
  // A reading that no particle explains changes nothing.
  turned.linear() = truth.linear() * expSo3(1.0 * axis);
  const std::vector<Pose> before = poses;
  EXPECT_FALSE(correctTilt({turned.linear().transpose() * Eigen::Vector3d::UnitZ(), sigma}, weights,
                           &random, &poses));
  EXPECT_EQ(poses[7].matrix(), before[7].matrix());
  PoseFilter filter{FilterParameters(), RefinementParameters()};
  filter.initialize(prior);
  EXPECT_THROW(filter.correctTilt({{NAN, 0, 1}, 0.02}), InputError);
}

std::shared_ptr<CEdgeMap> roomMap(uint64_t seed, bool refine = true) {
  Parameters params;
  params.filter.seed = seed;
  params.filter.particles = 300;
  params.refinement.enabled = refine;
  return std::make_shared<CEdgeMap>(roomFile(), params);
}

PoseGaussian startNear(const Pose& base) {
  PoseGaussian start;
  start.mean = base * expSe3((Twist() << 0.04, -0.03, 0.05, 0.01, -0.015, 0.02).finished());
  start.covariance.diagonal() << 25e-4, 25e-4, 25e-4, 4e-4, 4e-4, 4e-4;
  return start;
}

/// The truth is the pose of the rendered image. Two runs with one seed must give equal particles.
TEST(Filter, ConvergesInARenderedRoomAndIsReproducible) {
  const Pose base = kView * opticalOnBody().inverse();
  mrpt::obs::CSensoryFrame frame;
  frame.insert(roomObservation(opticalOnBody()));
  std::vector<double> first;
  for (int run = 0; run < 2; ++run) {
    CEdgeMonteCarloLocalization3D filter(roomMap(5));
    filter.initialize(startNear(base));
    mrpt::bayes::CParticleFilter particle_filter;
    for (int k = 0; k < 3; ++k) particle_filter.executeOn(filter, nullptr, &frame);
    const auto [covariance, mean] = filter.getCovarianceAndMean();
    EXPECT_LT((toPose(mean).translation() - base.translation()).norm(), 0.02);
    EXPECT_LT(rotationAngle(toPose(mean), base), 0.4 * M_PI / 180);
    EXPECT_GT(covariance(0, 0), 0);
    EXPECT_GT(filter.report().tempering, 0);
    std::vector<double> values;
    for (size_t i = 0; i < filter.size(); ++i) values.push_back(filter.getParticlePose(i).x);
    if (run == 0)
      first = values;
    else
      EXPECT_EQ(values, first);
  }
}

TEST(Filter, SidewaysAndVerticalOdometryMovesParticlesWithoutTurningThem) {
  // The 6-DoF motion model of MRPT is made for ground robots. This filter composes increments on
  // SE(3).
  for (const Eigen::Vector3d& step : {Eigen::Vector3d(0, 1, 0), Eigen::Vector3d(0, 0, 1)}) {
    CEdgeMonteCarloLocalization3D filter(roomMap(6));
    PoseGaussian start;
    start.covariance.diagonal().setConstant(1e-12);
    filter.initialize(start);
    mrpt::obs::CActionRobotMovement3D movement;
    movement.poseChange.mean = toMrpt(Pose(Eigen::Translation3d(step)));
    mrpt::obs::CActionCollection actions;
    actions.insert(movement);
    mrpt::bayes::CParticleFilter().executeOn(filter, &actions, nullptr);
    for (size_t i = 0; i < filter.size(); ++i) {
      const Pose p = toPose(filter.getParticlePose(i));
      // Noise of 4 %, five standard deviations.
      EXPECT_LT((p.translation() - step).norm(), 0.04 * 5);
      EXPECT_LT(rotationAngle(p, Pose::Identity()), 1e-3);
    }
  }
}

/// The particles lie uniformly in x from 1 to 1.1 m, so their mean is 1.05 m.
TEST(Filter, ParticlesSetThroughTheBaseClassAreTaken) {
  CEdgeMonteCarloLocalization3D filter(roomMap(7));
  filter.resetUniform({1, 2, 1, 0, 0, 0}, {1.1, 2.1, 1.1, 0.1, 0, 0}, 300);
  mrpt::bayes::CParticleFilter().executeOn(filter, nullptr, nullptr);
  EXPECT_NEAR(filter.estimate().mean.translation().x(), 1.05, 0.03);
}

TEST(Filter, BadInputIsAnErrorAndNotAPose) {
  CEdgeMonteCarloLocalization3D filter(roomMap(8));
  PoseGaussian start;
  start.mean.translation().x() = NAN;
  EXPECT_THROW(filter.initialize(start), InputError);
  filter.initialize(startNear(kView));
  mrpt::obs::CActionRobotMovement3D movement;
  movement.poseChange.mean.x(NAN);
  mrpt::obs::CActionCollection actions;
  actions.insert(movement);
  EXPECT_THROW(mrpt::bayes::CParticleFilter().executeOn(filter, &actions, nullptr), std::exception);
}

TEST(Resampling, SystematicKeepsExpectedNumbers) {
  const std::vector<double> weights{0.1, 0.2, 0.3, 0.4};
  std::vector<int> count(4);
  for (uint32_t i : systematicResample(weights, 1000, 0.37)) ++count[i];
  // The numbers of systematic resampling differ from the expected ones by less than one copy.
  for (int i = 0; i < 4; ++i) EXPECT_NEAR(count[i], 1000 * weights[i], 1);
}

/// The exponent must leave an effective sample size of a fifth of the 1000 particles.
TEST(Resampling, TemperingKeepsTheEffectiveSampleSize) {
  RandomSource random(33);
  std::vector<double> fixed(1000, 0), likelihood(1000);
  for (double& l : likelihood) l = 50 * random.normal();
  const double t = temperingExponent(fixed, likelihood, 0.2);
  std::vector<double> logs(1000);
  for (int i = 0; i < 1000; ++i) logs[i] = t * likelihood[i];
  EXPECT_NEAR(effectiveSampleSize(normalize(logs)), 200, 2);
  EXPECT_EQ(temperingExponent(fixed, std::vector<double>(1000, 3), 0.2), 1);
  // For Gaussian log-weights of variance v = (50 t)^2 the closed form is ESS/N = exp(-v).
  EXPECT_NEAR(50 * t, std::sqrt(-std::log(0.2)), 0.12);
}

}  // namespace
}  // namespace edge_mcl
