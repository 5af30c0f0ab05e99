#include "edge_mcl/mrpt_plugins/CEdgeMap.h"

#include <gtest/gtest.h>
#include <mrpt/config/CConfigFileMemory.h>
#include <mrpt/io/CMemoryStream.h>
#include <mrpt/maps/CMultiMetricMap.h>
#include <mrpt/obs/CObservation3DRangeScan.h>
#include <mrpt/obs/CObservationOdometry.h>
#include <mrpt/opengl/CSetOfObjects.h>
#include <mrpt/serialization/CArchive.h>

#include <fstream>
#include <functional>
#include <string>
#include <vector>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/base/random_source.h"
#include "edge_mcl/mrpt_plugins/CObservationMaskedImage.h"
#include "edge_mcl/mrpt_plugins/mrpt_conversions.h"
#include "support/error_text.h"
#include "support/mrpt_archive.h"
#include "support/mrpt_room.h"
#include "support/scenes.h"

namespace edge_mcl {
namespace {

mrpt::config::CConfigFileMemory iniFor(const std::string& extra) {
  return mrpt::config::CConfigFileMemory(
      "[MetricMap]\nedge_mcl::CEdgeMap_count = 1\n"
      "[MetricMap_edge_mcl::CEdgeMap_00_creationOpts]\nmodel_file = " +
      test::roomFile() + "\n" + extra);
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
  const CEdgeMap map(test::roomFile(), params);
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
  const CEdgeMap map(test::roomFile(), Parameters());
  const auto obs = test::roomObservation(opticalOnBody());
  RandomSource random(32);
  std::vector<Pose> poses;
  poses.reserve(50);
  for (int i = 0; i < 50; ++i)
    poses.push_back(test::kView * opticalOnBody().inverse() * expSe3(0.05 * random.normalTwist()));
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
  const CEdgeMap map(test::roomFile(), Parameters());
  const auto obs = test::roomObservation(opticalOnBody());
  mrpt::obs::CObservation3DRangeScan scan;
  EXPECT_FALSE(map.canComputeObservationLikelihood(scan));
  scan.hasIntensityImage = true;
  scan.intensityImage = obs->image;
  scan.cameraParamsIntensity = obs->cameraParams;
  scan.relativePoseIntensityWRTDepth = obs->cameraPose;
  const mrpt::poses::CPose3D base = toMrpt(test::kView * opticalOnBody().inverse());
  EXPECT_TRUE(map.canComputeObservationLikelihood(scan));
  EXPECT_EQ(map.computeObservationLikelihood(scan, base),
            map.computeObservationLikelihood(*obs, base));
}

/// The truth is the score of the same depths as a depth image.
TEST(EdgeMap, ScoresTheRangeImageOfARangeScan) {
  Parameters params;
  params.likelihood.cues = Cues::kDepth;
  params.depth.store_field = false;
  const CEdgeMap map(test::roomFile(), params);
  const CameraModel camera = test::pinhole(160, 120, 125);
  const cv::Mat metres = test::renderDepth(test::furnishedRooms(), camera, test::kView);
  DepthImage image;
  image.camera = camera;
  metres.convertTo(image.depth, CV_16U, 1000);
  CameraView view;
  view.depth = map.localization().prepareDepth(image);
  // The sensor is 20 cm ahead of the base and looks along the x axis of the base.
  const mrpt::poses::CPose3D mounting(0.2, 0, 0, 0, 0, 0);
  const Pose base = test::kView * opticalOnBody().inverse() * toPose(mounting).inverse();
  const double expected = map.localization().evaluate({view}, {test::kView}).front().log_likelihood;
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
  EXPECT_FALSE(map.canComputeObservationLikelihood(*test::roomObservation(opticalOnBody())));
}

TEST(EdgeMap, BrokenObservationsAreErrors) {
  const CEdgeMap map(test::roomFile(), Parameters());
  auto obs = test::roomObservation(opticalOnBody());
  obs->cameraParams.ncols = 100;
  EXPECT_THROW(map.computeObservationLikelihood(*obs, {}), std::exception);
  CObservationMaskedImage empty;
  empty.cameraParams = toMrpt(test::pinhole());
  EXPECT_THROW(map.computeObservationLikelihood(empty, {}), std::exception);
}

/// Reads an archive of a map that is written by hand.
CEdgeMap::Ptr mapFromArchive(uint8_t version,
                             const std::function<void(mrpt::serialization::CArchive&)>& write) {
  return std::dynamic_pointer_cast<CEdgeMap>(
      test::fromArchive("edge_mcl::CEdgeMap", version, write));
}

/// Version 1 had the parameter visibility.exact, for tests only. It is left out.
TEST(EdgeMapArchive, OfVersionOneIsReadWithoutTheParameterForTests) {
  const auto map = mapFromArchive(1, [](mrpt::serialization::CArchive& out) {
    out << test::roomFile() << std::string() << uint32_t{3};
    out << std::string("likelihood.sigma") << std::string("3.5");
    out << std::string("visibility.exact") << std::string("true");
    out << std::string("filter.particles") << std::string("321");
  });
  ASSERT_TRUE(map);
  EXPECT_EQ(map->modelFile(), test::roomFile());
  EXPECT_EQ(map->localization().params().likelihood.sigma, 3.5);
  EXPECT_EQ(map->localization().params().filter.particles, 321);
}

TEST(EdgeMapArchive, OfVersionTwoMayNotHoldIt) {
  test::expectError<std::exception>("visibility.exact", [] {
    mapFromArchive(2, [](mrpt::serialization::CArchive& out) {
      out << test::roomFile() << std::string() << uint32_t{1};
      out << std::string("visibility.exact") << std::string("true");
    });
  });
}

TEST(EdgeMapArchive, OfVersionZeroHasNoCamera) {
  const auto map = mapFromArchive(0, [](mrpt::serialization::CArchive& out) {
    out << test::roomFile() << uint32_t{1};
    out << std::string("likelihood.sigma") << std::string("3.5");
  });
  ASSERT_TRUE(map);
  EXPECT_EQ(map->localization().params().likelihood.sigma, 3.5);
}

TEST(EdgeMapArchive, OfTheFutureIsAnError) {
  test::expectError<std::exception>("unknown serialization version number: '3'",
                                    [] { mapFromArchive(3, [](auto&) {}); });
}

/// A map without a model gives an archive without a model. Reading it must empty a map.
TEST(EdgeMapArchive, OfAnEmptyMapEmptiesAMap) {
  CEdgeMap map(test::roomFile(), Parameters());
  mrpt::io::CMemoryStream stream;
  auto archive = mrpt::serialization::archiveFrom(stream);
  archive << CEdgeMap();
  stream.Seek(0);
  archive >> map;
  EXPECT_TRUE(map.isEmpty());
  EXPECT_EQ(map.modelFile(), "");
}

TEST(EdgeMap, WithoutAModelItScoresNothing) {
  CEdgeMap map;
  EXPECT_TRUE(map.isEmpty());
  test::expectError<Error>("no model is loaded", [&] { map.localization(); });
  const auto obs = test::roomObservation(opticalOnBody());
  EXPECT_FALSE(map.canComputeObservationLikelihood(*obs));
  EXPECT_THROW(map.views(*obs), Error);
  auto scene = mrpt::opengl::CSetOfObjects::Create();
  map.getVisualizationInto(*scene);
  EXPECT_EQ(scene->size(), 0u);
  map.load(test::roomFile(), {});
  EXPECT_FALSE(map.isEmpty());
  EXPECT_TRUE(map.canComputeObservationLikelihood(*obs));
  map.clear();
  EXPECT_TRUE(map.isEmpty());
}

TEST(EdgeMap, BadFilesAndParametersAreErrors) {
  test::expectError<InputError>("missing.obj", [] { CEdgeMap("/nowhere/missing.obj", {}); });
  Parameters params;
  params.likelihood.sigma = -1;
  test::expectError<ParameterError>("likelihood.sigma",
                                    [&] { CEdgeMap(test::roomFile(), params); });
  CEdgeMap map;
  test::expectError<InputError>("missing.yaml", [&] { map.useCamera("/nowhere/missing.yaml"); });
}

TEST(EdgeMap, AnIniFileWithoutAModelIsAnError) {
  mrpt::maps::TSetOfMetricMapInitializers initializers;
  const mrpt::config::CConfigFileMemory ini(
      std::string("[MetricMap]\nedge_mcl::CEdgeMap_count = 1\n"
                  "[MetricMap_edge_mcl::CEdgeMap_00_creationOpts]\nlikelihood.sigma = 3\n"));
  test::expectError<std::exception>("has no model_file",
                                    [&] { initializers.loadFromConfigFile(ini, "MetricMap"); });
}

/// An image without a calibration is scored with the camera of the file. The archive of the map
/// holds the name of this file.
TEST(EdgeMap, ImagesWithoutACalibrationUseTheGivenCamera) {
  const std::string file = testing::TempDir() + "edge_map_camera.yaml";
  std::ofstream(file) << "image_width: 320\nimage_height: 240\ncamera_matrix: {rows: 3, cols: 3, "
                         "data: [250, 0, 159.5, 0, 252.5, 123.5, 0, 0, 1]}\n"
                         "distortion_model: plumb_bob\ndistortion_coefficients: {rows: 1, cols: 5, "
                         "data: [0, 0, 0, 0, 0]}\n";
  CEdgeMap map(test::roomFile(), {});
  const auto calibrated = test::roomObservation(opticalOnBody());
  const auto bare = test::roomObservation(opticalOnBody());
  bare->cameraParams = {};
  bare->cameraParams.fx(0);
  bare->cameraParams.fy(0);
  const Pose base = test::kView * opticalOnBody().inverse();
  test::expectError<InputError>("no calibration", [&] { map.logLikelihoods(*bare, {base}); });
  const double expected = map.logLikelihoods(*calibrated, {base}).front();
  map.useCamera(file);
  EXPECT_EQ(map.logLikelihoods(*bare, {base}).front(), expected);
  const auto read = std::dynamic_pointer_cast<CEdgeMap>(test::throughArchive(map));
  ASSERT_TRUE(read);
  EXPECT_EQ(read->logLikelihoods(*bare, {base}).front(), expected);
  map.useCamera("");
  EXPECT_THROW(map.logLikelihoods(*bare, {base}), InputError);
}

TEST(EdgeMap, OtherObservationsSayNothing) {
  CEdgeMap map(test::roomFile(), {});
  const mrpt::obs::CObservationOdometry odometry;
  EXPECT_FALSE(map.canComputeObservationLikelihood(odometry));
  EXPECT_TRUE(map.views(odometry).empty());
  EXPECT_EQ(map.logLikelihoods(odometry, {test::kView, test::kView}), (std::vector<double>{0, 0}));
  // The model is fixed, so no observation changes it.
  EXPECT_FALSE(map.insertObservation(*test::roomObservation(opticalOnBody())));
}

/// After a change of its mask, an image must not be taken for the image before.
TEST(EdgeMap, AChangedImageIsScoredAnew) {
  const CEdgeMap map(test::roomFile(), {});
  const auto obs = test::roomObservation(opticalOnBody());
  const Pose base = test::kView * opticalOnBody().inverse();
  const double first = map.logLikelihoods(*obs, {base}).front();
  EXPECT_EQ(map.logLikelihoods(*obs, {base}).front(), first);
  obs->ignore_mask =
      mrpt::img::CImage(cv::Mat(240, 320, CV_8U, cv::Scalar(255)), mrpt::img::DEEP_COPY);
  EXPECT_EQ(map.logLikelihoods(*obs, {base}).front(), 0);  // no sample is left
  obs->ignore_mask = mrpt::img::CImage();
  EXPECT_EQ(map.logLikelihoods(*obs, {base}).front(), first);
}

TEST(EdgeMap, ItsNameTellsTheModelAndItsSize) {
  const CEdgeMap map(test::roomFile(), {});
  EXPECT_PRED2(test::contains, map.asString(), test::roomFile());
  EXPECT_PRED2(test::contains, map.asString(),
               std::to_string(map.localization().edges().lines.size()) + " lines");
}

/// Line elements of the OBJ file that saveMetricMapRepresentationToFile() writes.
size_t savedLines(const CEdgeMap& map) {
  const std::string prefix = testing::TempDir() + "edge_map";
  map.saveMetricMapRepresentationToFile(prefix);
  std::ifstream in(prefix + "_edges.obj");
  size_t count = 0;
  for (std::string text; std::getline(in, text);) count += text.rfind("l ", 0) == 0 ? 1 : 0;
  return count;
}

/// A box of the rooms has feature edges only, and no contours. The file must be a model with the
/// same lines.
TEST(EdgeMap, ItsLinesAreSavedAsAModel) {
  const CEdgeMap map(test::roomFile(), {});
  const EdgeModel& edges = map.localization().edges();
  EXPECT_EQ(savedLines(map), edges.lines.size());
  const CEdgeMap again(testing::TempDir() + "edge_map_edges.obj", {});
  double length = 0, length_again = 0;
  for (const EdgeLine& line : edges.lines) length += (line.end - line.start).norm();
  for (const EdgeLine& line : again.localization().edges().lines)
    length_again += (line.end - line.start).norm();
  // The file has six digits.
  EXPECT_NEAR(length_again, length, 1e-4 * length);
  test::expectError<InputError>("/nowhere/map_edges.obj",
                                [&] { map.saveMetricMapRepresentationToFile("/nowhere/map"); });
}

/// The header promises the feature lines. A column has contours, which are no feature lines.
TEST(EdgeMap, ContoursAreNotSaved) {
  const std::string file = testing::TempDir() + "column.obj";
  const MeshModel mesh = test::column(24, 0.5f, 2);
  std::ofstream out(file);
  for (const auto& v : mesh.vertices) out << "v " << v.transpose() << "\n";
  for (const auto& t : mesh.triangles)
    out << "f " << t[0] + 1 << " " << t[1] + 1 << " " << t[2] + 1 << "\n";
  out.close();
  const CEdgeMap map(file, {});
  size_t features = 0, contours = 0;
  for (const EdgeLine& line : map.localization().edges().lines)
    ++(line.kind == EdgeKind::kContour ? contours : features);
  ASSERT_GT(contours, 0u);
  EXPECT_EQ(savedLines(map), features);
}

}  // namespace
}  // namespace edge_mcl
