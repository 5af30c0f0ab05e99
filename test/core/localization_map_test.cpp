#include "edge_mcl/core/localization_map.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <thread>

#include "edge_mcl/core/base/error.h"
#include "edge_mcl/core/image/pixel_scale.h"
#include "support/error_text.h"
#include "support/map_views.h"
#include "support/room_view.h"
#include "support/temporary_folder.h"

namespace edge_mcl {
namespace {

using test::expectError;
using test::roomPicture;

const Pose kView = test::roomView();

TEST(Thinning, LeavesAboutAsManySamplesAsAskedFor) {
  const LocalizationMap map(test::furnishedRooms(), Parameters());
  const auto image = map.prepare(test::roomCamera(), roomPicture(), {}, "room");
  const auto samplesAt = [&](uint32_t thinning) {
    const VisibleSet set = map.visibility().exact(kView.translation(), thinning);
    size_t count = 0;
    for (const VisibleSet::Segment& s : set.segments)
      for (uint32_t i = 0; i < set.edgeSegment(s).sample_count; ++i) {
        Eigen::Vector2d pixel;
        const Eigen::Vector3d p =
            kView.inverse() * set.model->samplePosition(set.edgeSegment(s), i);
        count += (s.samples >> i & 1) && image->frame.camera.project(p, &pixel) &&
                 image->frame.camera.contains(pixel);
      }
    return count;
  };
  const size_t all = samplesAt(1);
  EXPECT_EQ(map.thinningFor({image}, kView, 0), 1u);
  EXPECT_EQ(map.thinningFor({image}, kView, 10 * all), 1u);
  for (const size_t most : {all / 10, all / 3}) {
    // The thinning is a whole number, and the number of samples in the image is only estimated. So
    // a factor of two is allowed.
    const size_t left = samplesAt(map.thinningFor({image}, kView, most));
    EXPECT_GT(left, most / 2);
    EXPECT_LT(left, 2 * most);
  }
}

/// Parameters for depth images alone. The voxels are large, so that the distance field is quick.
Parameters depthOnly() {
  Parameters params = test::depthAlone();
  params.depth.voxel_size = 0.1;
  return params;
}

class LocalizationMapOfAFile : public test::WithFolder {
 protected:
  /// @return path of a model file with one triangle, whose edges are boundaries
  std::string triangle() const {
    std::ofstream(path("triangle.obj")) << "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    return path("triangle.obj");
  }
  size_t filesInFolder() const {
    return static_cast<size_t>(std::distance(std::filesystem::directory_iterator(folder_), {}));
  }
};

TEST_F(LocalizationMapOfAFile, HasTheMeshAndItsEdges) {
  Parameters params;
  params.map.scale = 2;
  const LocalizationMap map(triangle(), params);
  EXPECT_EQ(map.mesh().triangles.size(), 1u);
  EXPECT_EQ(map.mesh().highest, Eigen::Vector3f(2, 2, 0));
  EXPECT_EQ(map.edges().lines.size(), 3u);
  EXPECT_EQ(map.params().map.scale, 2);
  EXPECT_EQ(map.visibility().model().lines.size(), 3u);
}

TEST_F(LocalizationMapOfAFile, AFileThatCannotBeUsedIsAnErrorWithItsName) {
  expectError<InputError>("none.obj", [&] { LocalizationMap(path("none.obj"), Parameters()); });
  std::ofstream(path("bad.obj")) << "this is no model\n";
  expectError<InputError>("bad.obj", [&] { LocalizationMap(path("bad.obj"), Parameters()); });
}

/// Without boundaries the triangle has no feature edges. Depth images do not need any.
TEST_F(LocalizationMapOfAFile, WithoutFeatureEdgesOnlyDepthImagesAreOfUse) {
  Parameters params;
  params.map.boundaries = false;
  expectError<InputError>("triangle.obj: the model has no feature edges",
                          [&] { LocalizationMap(triangle(), params); });
  Parameters depth = depthOnly();
  depth.map.boundaries = false;
  EXPECT_NO_THROW(LocalizationMap(triangle(), depth));
}

/// The distance field is computed once and kept beside the model, unless it is not wanted.
TEST_F(LocalizationMapOfAFile, KeepsTheDistanceFieldBesideTheModel) {
  Parameters params = depthOnly();
  const LocalizationMap without(triangle(), params);
  EXPECT_EQ(filesInFolder(), 1u);
  params.depth.store_field = true;
  const LocalizationMap with(triangle(), params);
  EXPECT_EQ(filesInFolder(), 2u);
}

TEST(LocalizationMap, AnIllegalParameterIsAnErrorThatNamesIt) {
  Parameters params;
  params.likelihood.sigma = -1;
  expectError<ParameterError>("likelihood.sigma",
                              [&] { LocalizationMap(test::furnishedRooms(), params); });
}

TEST(LocalizationMap, DepthImagesNeedFaces) {
  MeshSoup soup;
  soup.vertices = {{0, 0, 0}, {1, 0, 0}};
  soup.lines = {{0, 1}};
  const MeshModel lines = weldMesh(soup, 1e-6, "one line");
  EXPECT_NO_THROW(LocalizationMap(lines, Parameters()));
  expectError<InputError>("no faces", [&] { LocalizationMap(lines, depthOnly()); });
}

TEST(LocalizationMap, CuesSelectTheSensorData) {
  Parameters params = depthOnly();
  const LocalizationMap edges(test::furnishedRooms(), Parameters());
  EXPECT_TRUE(edges.usesImages());
  EXPECT_FALSE(edges.usesDepth());
  EXPECT_EQ(edges.depth(), nullptr);
  const LocalizationMap depth(test::furnishedRooms(), params);
  EXPECT_FALSE(depth.usesImages());
  EXPECT_TRUE(depth.usesDepth());
  params.likelihood.cues = Cues::kBoth;
  const LocalizationMap both(test::furnishedRooms(), params);
  EXPECT_TRUE(both.usesImages());
  EXPECT_TRUE(both.usesDepth());
  EXPECT_EQ(both.depth(), both.sharedDepth().get());
}

class LocalizationMapOfRooms : public testing::Test {
 protected:
  LocalizationMap map_{test::furnishedRooms(), Parameters()};
};

TEST_F(LocalizationMapOfRooms, APreparedImageHasEdgesAndTable) {
  cv::Mat mask(240, 320, CV_8U, cv::Scalar(0));
  mask(cv::Rect(100, 80, 60, 50)).setTo(1);
  cv::Mat colour;
  cv::cvtColor(roomPicture(), colour, cv::COLOR_GRAY2BGR);
  const auto image = map_.prepare(test::roomCamera(), colour, mask, "room");
  const double scale = pixelScale(map_.params().image, colour.size());
  const EdgeImage expected = findEdges(colour, mask, scaledBy(scale, map_.params().image), "room");
  EXPECT_EQ(image->pixel_scale, scale);
  EXPECT_EQ(cv::norm(image->edges.edges, expected.edges, cv::NORM_INF), 0);
  EXPECT_EQ(image->pixels.list().size(), expected.edgeCount());
  ASSERT_NE(image->frame.table, nullptr);
  EXPECT_TRUE(image->frame.table->hasIgnored());
  EXPECT_EQ(image->frame.picture, nullptr);
  EXPECT_EQ(image->frame.camera.width, 320);
  EXPECT_EQ(image->frame.sample_step, map_.edges().sample_step);
  EXPECT_EQ(image->frame.thinning, 1u);
}

TEST_F(LocalizationMapOfRooms, AWrongImageIsAnErrorThatNamesItsOrigin) {
  const auto prepare = [&](const CameraModel& camera, const cv::Mat& image, const cv::Mat& mask) {
    return [=] { map_.prepare(camera, image, mask, "left camera"); };
  };
  const CameraModel camera = test::roomCamera();
  expectError<InputError>("left camera: the image has 320x240 pixels, camera_info says 640x480",
                          prepare(test::pinhole(640, 480), roomPicture(), {}));
  expectError<InputError>("left camera", prepare(camera, cv::Mat(240, 320, CV_32F), {}));
  expectError<InputError>("left camera: the mask has 32x24",
                          prepare(camera, roomPicture(), cv::Mat(24, 32, CV_8U)));
  expectError<InputError>("left camera: the mask must be 8-bit",
                          prepare(camera, roomPicture(), cv::Mat(240, 320, CV_16U)));
  expectError<InputError>(
      "too large", prepare(test::pinhole(12000, 9000, 9000), cv::Mat(9000, 12000, CV_8U), {}));
}

/// A backend with scores that tell what it was asked.
class TellingBackend : public LikelihoodBackend {
 public:
  TellingBackend(bool makes_tables, int* prefetched)
      : makes_tables_(makes_tables), prefetched_(prefetched) {}
  std::vector<PoseScore> evaluate(const LikelihoodFrame& frame,
                                  const std::vector<Pose>& camera_poses) const override {
    std::vector<PoseScore> scores;
    for (const Pose& pose : camera_poses) {
      PoseScore score;
      score.log_likelihood = pose.translation().x() + 1000 * frame.thinning;
      score.sample_weight = 30;
      score.line_count = 4;
      scores.push_back(score);
    }
    return scores;
  }
  std::string name() const override { return "telling"; }
  bool makesTables(const ImageParameters&) const override { return makes_tables_; }
  void prefetch(const LikelihoodFrame& frame) const override {
    *prefetched_ += frame.picture != nullptr;
  }

 private:
  bool makes_tables_;
  int* prefetched_;
};

TEST_F(LocalizationMapOfRooms, ABackendThatMakesTablesGetsThePicture) {
  int prefetched = 0;
  map_.setBackend(std::make_unique<TellingBackend>(true, &prefetched));
  EXPECT_EQ(map_.backend().name(), "telling");
  const auto image = map_.prepare(test::roomCamera(), roomPicture(), {}, "room");
  EXPECT_EQ(prefetched, 1);
  EXPECT_EQ(image->frame.table, nullptr);
  ASSERT_NE(image->frame.picture, nullptr);
  EXPECT_EQ(cv::norm(image->frame.picture->grey(), roomPicture(), cv::NORM_INF), 0);
  EXPECT_GT(image->pixels.list().size(), 100u);  // the refinement needs the edges all the same
  map_.setBackend(std::make_unique<TellingBackend>(false, &prefetched));
  EXPECT_NE(map_.prepare(test::roomCamera(), roomPicture(), {}, "room")->frame.table, nullptr);
  EXPECT_EQ(prefetched, 1);
}

/// Every view is scored at the pose of its camera and with its thinning, and the scores are added.
/// The score per line is that of the sum in the robust model, see combineLines().
TEST_F(LocalizationMapOfRooms, ViewsAreScoredAtTheirCamerasAndAdded) {
  int prefetched = 0;
  map_.setBackend(std::make_unique<TellingBackend>(false, &prefetched));
  const auto image = map_.prepare(test::roomCamera(), roomPicture(), {}, "room");
  // The base looks along y, so 0.5 m in front of it is not along the map's x axis, and 0.2 m to its
  // left is.
  Pose base = Pose::Identity();
  base.linear() = rotationFromAngles(0, 0, M_PI / 2);
  base.translation() = Eigen::Vector3d(7, 1, 1);
  const Pose T_base_left(Eigen::Translation3d(0.5, 0.2, 0));
  const std::vector<CameraView> views = {
      {image, Pose::Identity(), 1}, {image, T_base_left, 5}, CameraView()};
  const std::vector<PoseScore> scores = map_.evaluate(views, {base, Pose::Identity()});
  ASSERT_EQ(scores.size(), 2u);
  const double first = 7 + 1000, second = 7 - 0.2 + 5000;
  EXPECT_NEAR(scores[0].log_likelihood, first + second, 1e-9);
  EXPECT_NEAR(scores[1].log_likelihood, 1000 + 0.5 + 5000, 1e-9);
  EXPECT_EQ(scores[0].sample_weight, 60);
  EXPECT_EQ(scores[0].line_count, 8);
  const LikelihoodParameters& p = map_.params().likelihood;
  EXPECT_NEAR(scores[0].line_score_sum, (first + second) * (1 + 3 * p.line_correlation) / p.scale,
              1e-6);
  EXPECT_EQ(scores[0].depth_points, 0);
  EXPECT_EQ(map_.evaluate({}, {base}).front().log_likelihood, 0);
  EXPECT_TRUE(map_.evaluate(views, {}).empty());
}

/// The depth part of the score is that of DepthLikelihood alone.
TEST(LocalizationMap, DepthImagesAddTheirScore) {
  const LocalizationMap map(test::furnishedRooms(), depthOnly());
  const CameraView view = test::depthInRoom(map);
  const DepthScore alone = map.depth()->evaluate(*view.depth, {kView}).front();
  const PoseScore score = map.evaluate({view}, {kView}).front();
  EXPECT_GT(alone.log_likelihood, 10);
  EXPECT_EQ(score.log_likelihood, alone.log_likelihood);
  EXPECT_EQ(score.depth_log_likelihood, alone.log_likelihood);
  EXPECT_EQ(score.depth_points, static_cast<float>(view.depth->count));
  EXPECT_FLOAT_EQ(score.depth_points_on_model, score.depth_points * alone.agreement);
  EXPECT_EQ(score.line_count, 0);
  // A map without the depth cue ignores depth images.
  const LocalizationMap edges(test::furnishedRooms(), Parameters());
  EXPECT_EQ(edges.evaluate({view}, {kView}).front().log_likelihood, 0);
}

/// At the true pose nearly all samples have an image edge. 30 cm aside few have one.
TEST_F(LocalizationMapOfRooms, MatchesAreCountedAtAPose) {
  const CameraView view = test::viewInRoom(map_);
  const RefinementResult here = map_.match({view}, kView);
  EXPECT_GT(here.used_samples, 100);
  EXPECT_GT(here.matched_samples, 0.9 * here.used_samples);
  const RefinementResult aside = map_.match({view}, kView * Pose(Eigen::Translation3d(0.3, 0, 0)));
  EXPECT_LT(aside.matched_samples, 0.7 * aside.used_samples);
  EXPECT_EQ(map_.match({test::darkView(map_)}, kView).matched_samples, 0);
}

/// Both refinements find the true pose from 2 cm away. The rough one uses fewer samples.
TEST(LocalizationMap, ARoughRefinementUsesFewerSamples) {
  Parameters params;
  params.refinement.start_samples = 100;
  const LocalizationMap map(test::furnishedRooms(), params);
  const CameraView view = test::viewInRoom(map);
  const Pose start = kView * Pose(Eigen::Translation3d(0.02, 0, 0));
  const RefinementResult fine = map.refine({view}, start, std::nullopt);
  const RefinementResult rough = map.refineRoughly({view}, start, std::nullopt);
  EXPECT_LT(rough.used_samples, fine.used_samples / 2);
  EXPECT_GT(rough.used_samples, 50);
  // The picture has one ray per pixel, so its edges have an error of up to half a pixel. At 2 m
  // this is 5 mm for one edge, and less for all together. Fewer samples average less.
  EXPECT_LT((fine.pose.translation() - kView.translation()).norm(), 0.005);
  EXPECT_LT((rough.pose.translation() - kView.translation()).norm(), 0.01);
}

TEST_F(LocalizationMapOfRooms, ViewsWithoutAnImageAreNotThinned) {
  EXPECT_EQ(map_.thinningFor(CameraView(), kView, 10), 1u);
}

/// A building of 8 m x 5 m x 2.6 m. Many threads that ask at once get one object.
TEST(LocalizationMap, FreeSpaceAndPlacesAreComputedOnce) {
  Parameters params;
  params.search.max_places = 200;
  const LocalizationMap map(test::furnishedRooms(), params);
  std::vector<std::shared_ptr<const SearchPlaces>> places(4);
  std::vector<std::shared_ptr<const FreeSpace>> spaces(4);
  std::vector<std::thread> threads;
  for (size_t i = 0; i < 4; ++i)
    threads.emplace_back([&, i] {
      places[i] = map.searchPlaces();
      spaces[i] = map.freeSpace();
    });
  for (auto& thread : threads) thread.join();
  for (size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(places[i], map.searchPlaces());
    EXPECT_EQ(spaces[i], map.freeSpace());
  }
  EXPECT_TRUE(spaces[0]->contains({2, 2.5, 1.4}));
  EXPECT_FALSE(spaces[0]->contains({2, 2.5, 2.5})) << "this is 10 cm below the ceiling";
  EXPECT_FALSE(spaces[0]->contains({20, 2.5, 1.4}));
  EXPECT_GT(places[0]->places.size(), 20u);
  for (const SearchPlaces::Place& place : places[0]->places)
    EXPECT_TRUE(spaces[0]->contains(place.position));
}

/// No camera fits into a room of 2.6 m height with a clearance of 3 m. The second call fails as the
/// first one does.
TEST(LocalizationMap, ASpaceWithoutPlacesIsAnError) {
  Parameters params;
  params.search.clearance = 3;
  const LocalizationMap map(test::furnishedRooms(), params);
  EXPECT_THROW(map.searchPlaces(), InputError);
  EXPECT_THROW(map.searchPlaces(), InputError);
}

/// Visibility and backend refer to mesh and edges, which must stay where they are.
TEST(LocalizationMap, AMovedMapScoresAsBefore) {
  LocalizationMap map(test::furnishedRooms(), Parameters());
  const CameraView view = test::viewInRoom(map);
  const double before = map.evaluate({view}, {kView}).front().log_likelihood;
  ASSERT_GT(before, 10);
  const LocalizationMap moved(std::move(map));
  EXPECT_EQ(moved.evaluate({view}, {kView}).front().log_likelihood, before);
  EXPECT_GT(moved.match({view}, kView).matched_samples, 100);
}

}  // namespace
}  // namespace edge_mcl
