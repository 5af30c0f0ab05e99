#include "edge_mcl/localization/search/pose_sharpener.h"

#include <gtest/gtest.h>

#include <set>
#include <thread>
#include <vector>

#include "edge_mcl/core/base/random_source.h"
#include "support/map_views.h"

namespace edge_mcl {
namespace {

Pose displaced(const Pose& pose, double metres, double radians, RandomSource* random) {
  return pose *
         expSe3(
             (Twist() << metres * random->direction(), radians * random->direction()).finished());
}

TEST(IsNear, NeedsBothLimits) {
  const Pose a = test::roomView();
  const auto moved = [&](double metres, double radians) {
    return a * expSe3((Twist() << 0, 0, 0, 0, 0, radians).finished()) *
           Pose(Eigen::Translation3d(0, metres, 0));
  };
  EXPECT_TRUE(isNear(a, a, 1e-9, 1e-6));
  EXPECT_TRUE(isNear(a, moved(0.09, 0.04), 0.1, 0.05));
  EXPECT_FALSE(isNear(a, moved(0.11, 0.04), 0.1, 0.05));
  EXPECT_FALSE(isNear(a, moved(0.09, 0.06), 0.1, 0.05));
  EXPECT_TRUE(isNear(moved(0.09, 0.04), a, 0.1, 0.05));
  EXPECT_TRUE(isNear(a, moved(0.09, 0.04), PoseTolerance{0.1, 0.05}));
  EXPECT_FALSE(isNear(a, moved(0, M_PI), kSamePlace));
}

using SampleKeys = std::set<std::pair<uint32_t, uint32_t>>;  // segment, sample

SampleKeys keysOf(const VisibleSet& set) {
  SampleKeys result;
  for (const auto& s : set.segments)
    for (uint32_t i = 0; i < EdgeSegment::kMaxSamples; ++i)
      if (s.samples >> i & 1u) result.insert({s.index, i});
  return result;
}

/// The truth is the visible set of all directions, projected into cameras that are turned by up to
/// 25 degrees.
TEST(VisibleInView, IsCompleteForATurnedCamera) {
  const LocalizationMap map(test::furnishedRooms(), Parameters());
  const CameraModel camera = test::roomCamera();
  RandomSource random(71);
  size_t in_image = 0, kept = 0, all = 0;
  for (int k = 0; k < 10; ++k) {
    const Eigen::Vector3d position(1 + 2 * random.uniform(), 1 + 3 * random.uniform(), 1.4);
    const Pose pose = test::lookAlong(position, random.direction());
    const SampleKeys full = keysOf(map.visibility().exact(position));
    const SampleKeys some = keysOf(*visibleInView(map.visibility(), pose, camera, 1));
    kept += some.size();
    all += full.size();
    for (int turn = 0; turn < 10; ++turn) {
      const Pose turned =
          pose * expSe3((Twist() << 0, 0, 0, kTurnInView * random.direction()).finished());
      for (const auto& key : full) {
        const Eigen::Vector3d p =
            map.edges().samplePosition(map.edges().segments[key.first], key.second);
        Eigen::Vector2d pixel;
        if (!camera.project(turned.inverse() * p, &pixel) || !camera.contains(pixel)) continue;
        ++in_image;
        EXPECT_EQ(some.count(key), 1u);
      }
    }
  }
  EXPECT_GT(in_image, 5000u);
  // Samples behind the camera are left out.
  EXPECT_LT(kept, all);
}

TEST(VisibleInView, ThinningLeavesEverySoManyth) {
  const LocalizationMap map(test::furnishedRooms(), Parameters());
  const auto full = visibleInView(map.visibility(), test::roomView(), test::roomCamera(), 1);
  const auto thin = visibleInView(map.visibility(), test::roomView(), test::roomCamera(), 3);
  size_t expected = 0;
  for (const auto& key : keysOf(*full))
    expected += (map.edges().segments[key.first].first_sample + key.second) % 3 == 0 ? 1 : 0;
  EXPECT_EQ(keysOf(*thin).size(), expected);
}

/// The camera stands in the furnished rooms, at a known pose.
class PoseSharpenerTest : public testing::Test {
 protected:
  static PoseGaussian wide(const Pose& mean) { return {mean, 0.04 * Matrix6::Identity()}; }

  /// The views with everything that the search computes for them.
  static SearchViews seen(const LocalizationMap& map, const std::vector<CameraView>& views) {
    const SmallImages small(map.params(), 160, map.edges().sample_step, 1);
    SearchViews result;
    result.views = views;
    for (const CameraView& view : views) {
      result.small.push_back(view.image ? small.make(*view.image) : nullptr);
      result.contours.push_back(
          view.image ? std::make_shared<const ImageContours>(view.image->edges) : nullptr);
    }
    return result;
  }

  const LocalizationMap map_{test::furnishedRooms(), Parameters()};
  const PoseSharpener sharpener_{map_};
  const SearchViews seen_ = seen(map_, {test::viewInRoom(map_)});
  const Pose truth_ = test::roomView();
};

/// The truth is the pose of the rendered image.
TEST_F(PoseSharpenerTest, FindsTheTruePoseFromNearby) {
  RandomSource random(72);
  for (int i = 0; i < 10; ++i) {
    const Pose start = displaced(truth_, 0.05, 0.02, &random);
    const FoundPose found = sharpener_.sharpen(seen_, start, wide(start));
    // The refinement is good to some millimetres in this room.
    EXPECT_LT((found.pose.translation() - truth_.translation()).norm(), 0.02) << i;
    EXPECT_LT(rotationAngle(found.pose, truth_), 0.4 * M_PI / 180) << i;
    EXPECT_GT(found.match_ratio, 0.6);
    EXPECT_LE(found.match_ratio, 1);
    EXPECT_GT(found.evidence, 0);
    EXPECT_LT(found.depth_agreement, 0);  // there is no depth image
    EXPECT_TRUE(found.covariance.allFinite());
    EXPECT_LT(found.covariance(0, 0), 0.04);  // less than the prior
  }
}

TEST_F(PoseSharpenerTest, AWrongPoseHasALowerScore) {
  const FoundPose right = sharpener_.sharpen(seen_, truth_, wide(truth_));
  RandomSource random(73);
  for (int i = 0; i < 10; ++i) {
    // The pose has an error of 0.5 m and 34 degrees. A narrow prior keeps it there.
    const Pose wrong = displaced(truth_, 0.5, 0.6, &random);
    const FoundPose found = sharpener_.sharpen(seen_, wrong, {wrong, 1e-8 * Matrix6::Identity()});
    EXPECT_LT((found.pose.translation() - wrong.translation()).norm(), 0.01);
    EXPECT_LT(found.log_likelihood, right.log_likelihood - 20) << i;
    EXPECT_LT(found.evidence, right.evidence) << i;
    EXPECT_LT(found.match_ratio, right.match_ratio) << i;
  }
}

/// In a dark image no model edge has an image edge. Visible model edges without an image edge count
/// against the pose.
TEST_F(PoseSharpenerTest, EdgesThatTheImageDoesNotShowCount) {
  const SearchViews dark = seen(map_, {test::darkView(map_)});
  const FoundPose found = sharpener_.sharpen(dark, truth_, wide(truth_));
  EXPECT_EQ(found.match_ratio, 0);
  EXPECT_LT(found.log_likelihood, 0);
}

/// Two equal cameras give the evidence of one.
TEST_F(PoseSharpenerTest, TheEvidenceIsAMeanOverTheImages) {
  const CameraView view = seen_.views.front();
  const PoseGaussian fixed{truth_, 1e-10 * Matrix6::Identity()};
  const FoundPose one = sharpener_.sharpen(seen_, truth_, fixed);
  const FoundPose two = sharpener_.sharpen(seen(map_, {view, view}), truth_, fixed);
  // The prior leaves the pose some micrometres of freedom.
  EXPECT_NEAR(two.evidence, one.evidence, 1e-3 * std::abs(one.evidence));
  EXPECT_NEAR(two.log_likelihood, 2 * one.log_likelihood, 1e-2 * std::abs(one.log_likelihood));
}

TEST_F(PoseSharpenerTest, TheExtrinsicsAreUsed) {
  const Pose T_base_camera = Pose(Eigen::Translation3d(0.2, -0.1, 0.3)) * opticalOnBody();
  const Pose base = truth_ * T_base_camera.inverse();
  const SearchViews mounted = seen(map_, {test::viewInRoom(map_, truth_, T_base_camera)});
  RandomSource random(74);
  const Pose start = displaced(base, 0.03, 0.02, &random);
  const FoundPose found = sharpener_.sharpen(mounted, start, wide(start));
  EXPECT_LT((found.pose.translation() - base.translation()).norm(), 0.02);
}

/// Many threads must give the bits of one.
TEST_F(PoseSharpenerTest, ServesManyThreads) {
  constexpr size_t kStarts = 24;
  RandomSource random(75);
  std::vector<Pose> starts;
  for (size_t i = 0; i < kStarts; ++i) starts.push_back(displaced(truth_, 0.1, 0.05, &random));
  std::vector<FoundPose> found(kStarts);
  std::vector<std::thread> threads;
  threads.reserve(4);
  for (size_t t = 0; t < 4; ++t)
    threads.emplace_back([&, t] {
      for (size_t i = t; i < kStarts; i += 4)
        found[i] = sharpener_.sharpen(seen_, starts[i], wide(starts[i]));
    });
  for (std::thread& thread : threads) thread.join();
  for (size_t i = 0; i < kStarts; ++i) {
    const FoundPose alone = sharpener_.sharpen(seen_, starts[i], wide(starts[i]));
    EXPECT_EQ(found[i].pose.matrix(), alone.pose.matrix());
    EXPECT_EQ(found[i].log_likelihood, alone.log_likelihood);
  }
}

/// With depth alone the score is the log-likelihood of the depth points. The truth is the slow
/// version of the depth likelihood.
TEST(PoseSharpenerWithDepth, TheScoreIsTheLikelihoodOfTheDepthPoints) {
  const LocalizationMap map(test::furnishedRooms(), test::depthAlone());
  const PoseSharpener sharpener(map);
  const SearchViews seen{{test::depthInRoom(map)}, {nullptr}, {nullptr}};
  RandomSource random(76);
  const Pose start = displaced(test::roomView(), 0.05, 0.02, &random);
  const FoundPose found = sharpener.sharpen(seen, start, {start, 0.04 * Matrix6::Identity()});
  EXPECT_LT((found.pose.translation() - test::roomView().translation()).norm(), 0.02);
  const DepthScore slow = map.depth()->evaluateSlowly(*seen.views[0].depth, found.pose);
  // The kernel adds up in single precision.
  EXPECT_NEAR(found.log_likelihood, slow.log_likelihood, 1e-3 * std::abs(slow.log_likelihood));
  EXPECT_NEAR(found.depth_agreement, slow.agreement, 1e-3);
  EXPECT_GT(found.depth_agreement, 0.9);
  EXPECT_LT(found.match_ratio, 0);  // there is no image
  EXPECT_EQ(found.evidence, 0);
}

}  // namespace
}  // namespace edge_mcl
