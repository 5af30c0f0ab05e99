#include "edge_mcl/localization/objects/object_follower.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "support/scenes.h"

namespace edge_mcl {
namespace {

/// A thing of the scene: an upright box with a colour.
struct Thing {
  Eigen::AlignedBox3d box;
  cv::Vec3b colour{60, 60, 200};
};

Thing thing(double x, double y, double width = 0.5, double height = 1.7) {
  const Eigen::Vector3d half(width / 2, width / 2, 0);
  return {{Eigen::Vector3d(x, y, 0) - half, Eigen::Vector3d(x, y, height) + half}};
}

/// First box on a ray, in lengths of its direction; infinite: none.
double hit(const Eigen::AlignedBox3d& box, const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  const Eigen::Array3d a = (box.min() - from).array() / to.array(),
                       b = (box.max() - from).array() / to.array();
  const double enter = a.min(b).maxCoeff(), leave = a.max(b).minCoeff();
  return enter <= leave && enter > 0 ? enter : std::numeric_limits<double>::infinity();
}

/// A depth camera that flies at 1.2 m in front of a wall at x = 8.
class Room {
 public:
  static constexpr double kRate = 15;

  /// Looks at the things from a place, in this direction (rad; 0: along x).
  void look(double time, const std::vector<Thing>& things, const Eigen::Vector2d& from = {0, 0},
            double heading = 0) {
    ForeignDepth view;
    view.image.camera = kCamera;
    view.image.depth = cv::Mat(kCamera.height, kCamera.width, CV_32F, cv::Scalar(0));
    view.foreign.spacing = 1;
    view.T_map_depth.linear() = Eigen::AngleAxisd(heading, Eigen::Vector3d::UnitZ()) *
                                (Eigen::Matrix3d() << 0, 0, 1, -1, 0, 0, 0, -1, 0).finished();
    view.T_map_depth.translation() << from.x(), from.y(), 1.2;
    cv::Mat colours(kCamera.height, kCamera.width, CV_8UC3, cv::Scalar::all(128));
    for (int v = 0; v < kCamera.height; ++v)
      for (int u = 0; u < kCamera.width; ++u) {
        const Eigen::Vector3d ray((u - kCamera.cx) / kCamera.fx, (v - kCamera.cy) / kCamera.fy, 1);
        const Eigen::Vector3d direction = view.T_map_depth.linear() * ray;
        double depth = hit({Eigen::Vector3d(8, -50, -50), Eigen::Vector3d(9, 50, 50)},
                           view.T_map_depth.translation(), direction);
        for (const Thing& t : things) {
          const double of_thing = hit(t.box, view.T_map_depth.translation(), direction);
          if (of_thing >= depth) continue;
          depth = of_thing;
          colours.at<cv::Vec3b>(v, u) = t.colour;
        }
        if (!std::isfinite(depth)) continue;
        view.image.depth.at<float>(v, u) = static_cast<float>(depth);
        const bool is_wall = (view.T_map_depth * (depth * ray)).x() > 7.9;
        if (!is_wall) view.foreign.points.push_back((depth * ray).cast<float>());
      }
    now_ = time;
    objects_.update(time, {view}, {{colours, kCamera, view.T_map_depth}}, nullptr, {});
  }
  /// Looks at things that move, from a camera at rest.
  void watch(double begin, double end, const std::function<std::vector<Thing>(double)>& things) {
    for (double t = begin; t < end - 1e-6; t += 1 / kRate) look(t, things(t));
  }
  std::vector<ObjectState> objects() const { return objects_.objects(now_); }
  /// The only object. @throws when there is another number of them
  ObjectState only() const {
    if (objects().size() != 1)
      throw std::runtime_error(std::to_string(objects().size()) + " objects");
    return objects().front();
  }

 private:
  static CameraModel camera() {
    CameraModel camera;
    camera.width = 160;
    camera.height = 120;
    camera.fx = camera.fy = 125;
    camera.cx = 79.5;
    camera.cy = 59.5;
    return camera;
  }
  const CameraModel kCamera = camera();
  ObjectFollower objects_;
  double now_ = 0;
};

/// The voxels are 0.1 m wide.
constexpr double kVoxel = kObjectVoxel;

TEST(ObjectFollower, AThingThatStandsHasItsBoxAndNoVelocity) {
  Room room;
  const Thing box = thing(4, 0.3);
  for (int i = 0; i < 45; ++i)  // the camera flies around it by 60 degrees
    room.look(i / Room::kRate, {box}, {4 - 3 * std::cos(i * 0.023), 0.3 - 3 * std::sin(i * 0.023)},
              i * 0.023);
  const ObjectState found = room.only();
  EXPECT_EQ(found.number, 1);
  EXPECT_FALSE(found.is_moving);
  EXPECT_TRUE(found.is_in_view);
  EXPECT_EQ(found.velocity, Eigen::Vector3d::Zero());
  EXPECT_EQ(found.still_since, 0);
  // Front and one side were seen, and so the whole ground.
  EXPECT_LT((found.box.min() - box.box.min()).cwiseAbs().head<2>().maxCoeff(), kVoxel);
  EXPECT_LT((found.box.max() - box.box.max()).cwiseAbs().maxCoeff(), kVoxel);
}

struct Way {
  const char* name;
  Eigen::Vector2d from, velocity;
};

class WalkingObject : public ::testing::TestWithParam<Way> {};

TEST_P(WalkingObject, HasAPlaceAndAVelocity) {
  const Way& way = GetParam();
  Room room;
  const auto at = [&](double t) -> Eigen::Vector2d { return way.from + t * way.velocity; };
  room.watch(0, 2, [&](double t) { return std::vector<Thing>{thing(at(t).x(), at(t).y())}; });
  const ObjectState found = room.only();
  EXPECT_TRUE(found.is_moving);
  const Eigen::Vector2d end = at(2 - 1 / Room::kRate);
  EXPECT_LT((found.box.center().head<2>() - end).norm(), 0.2);
  EXPECT_LT((found.velocity.head<2>() - way.velocity).norm(), 0.3);
}

INSTANTIATE_TEST_SUITE_P(Ways, WalkingObject,
                         ::testing::Values(Way{"across", {4, -1}, {0, 1}},
                                           Way{"slowly", {4, 0.8}, {0, -0.5}},
                                           Way{"towards", {6, 0.2}, {-1.2, 0}},
                                           Way{"away", {3, 0.2}, {1.2, 0}},
                                           Way{"aslant", {3, 0.5}, {0.8, -0.6}}),
                         [](const auto& way) { return std::string(way.param.name); });

TEST(ObjectFollower, AThingThatStopsStandsStill) {
  Room room;
  room.watch(0, 4, [](double t) { return std::vector<Thing>{thing(4, -1 + std::min(t, 1.5))}; });
  const ObjectState found = room.only();
  EXPECT_EQ(found.number, 1);
  EXPECT_FALSE(found.is_moving);
  EXPECT_GT(found.still_since, 1.5);
  EXPECT_LT(found.still_since, 3);
}

/// The camera turns away for five seconds. One thing stands, the other one has gone on.
TEST(ObjectFollower, ThingsOutOfViewAreKnownAgain) {
  Room room;
  const Thing chair = thing(5, 1, 0.5, 0.9);
  const auto walker = [](double t) { return thing(4.0 + 0.1 * t, -0.8 + 0.05 * t); };
  room.watch(0, 1, [&](double t) { return std::vector<Thing>{chair, walker(t)}; });
  const std::vector<ObjectState> before = room.objects();
  ASSERT_EQ(before.size(), 2U);
  for (double t = 1; t < 6; t += 1 / Room::kRate) room.look(t, {chair, walker(t)}, {0, 0}, M_PI);
  ASSERT_EQ(room.objects().size(), 2U);
  EXPECT_FALSE(room.objects()[0].is_in_view);
  room.watch(6, 7, [&](double t) { return std::vector<Thing>{chair, walker(t)}; });
  const std::vector<ObjectState> after = room.objects();
  ASSERT_EQ(after.size(), 2U);
  for (size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(after[i].number, before[i].number);
    EXPECT_LT((after[i].box.center() - before[i].box.center()).norm(), 0.9);
    EXPECT_TRUE(after[i].is_in_view);
  }
}

TEST(ObjectFollower, AThingThatLooksOtherwiseIsAnotherOne) {
  Room room;
  Thing red = thing(4, -0.8), green = thing(4, 0.6);
  green.colour = {40, 200, 40};
  room.watch(0, 1, [&](double) { return std::vector<Thing>{red}; });
  for (double t = 1; t < 3; t += 1 / Room::kRate) room.look(t, {}, {0, 0}, M_PI);
  room.watch(3, 4, [&](double) { return std::vector<Thing>{green}; });
  EXPECT_EQ(room.only().number, 2) << "the first one has gone";
}

TEST(ObjectFollower, AThingThatIsTakenAwayHasNoPlace) {
  Room room;
  room.watch(0, 1, [](double) { return std::vector<Thing>{thing(4, 0)}; });
  ASSERT_EQ(room.objects().size(), 1U);
  room.watch(1, 2, [](double) { return std::vector<Thing>{}; });
  EXPECT_TRUE(room.objects().empty());
  // It stands somewhere else later.
  room.watch(4, 5, [](double) { return std::vector<Thing>{thing(4.5, 1)}; });
  EXPECT_EQ(room.only().number, 1);
}

/// Nobody walks 15 m on the way of a velocity that was measured ten seconds ago.
TEST(ObjectFollower, AfterAPauseAnotherThingIsAnotherOne) {
  Room room;
  Thing green = thing(6.5, 1.2);
  green.colour = {40, 200, 40};
  room.watch(0, 2, [](double t) { return std::vector<Thing>{thing(4, -1 + 0.7 * t)}; });
  ASSERT_TRUE(room.only().is_moving);
  room.watch(12, 13, [&](double) { return std::vector<Thing>{green}; });
  const ObjectState found = room.objects().back();
  EXPECT_EQ(found.number, 2);
  EXPECT_LT((found.box.center().head<2>() - Eigen::Vector2d(6.5, 1.2)).norm(), 0.3);
}

/// Chairs of one kind stand in many rooms. One that has always stood still does not walk.
TEST(ObjectFollower, AThingThatStandsStillKeepsItsPlaceOutOfView) {
  Room room;
  const std::vector<Thing> chairs{thing(4, -0.8, 0.5, 0.9), thing(-4, 0.8, 0.5, 0.9)};
  room.watch(0, 2, [&](double) { return std::vector<Thing>(chairs); });
  for (double t = 2; t < 30; t += 1 / Room::kRate) room.look(t, chairs, {0, 0}, M_PI);
  const std::vector<ObjectState> found = room.objects();
  ASSERT_EQ(found.size(), 2U);
  EXPECT_LT((found[0].box.center().head<2>() - Eigen::Vector2d(4, -0.8)).norm(), 0.3);
  EXPECT_FALSE(found[0].is_in_view);
  EXPECT_TRUE(found[1].is_in_view);
}

/// No place of its back was seen from the front. It is the same thing, and it has not moved.
TEST(ObjectFollower, AThingThatIsSeenFromBehindHasStoodSinceItWasSeenFromTheFront) {
  Room room;
  const std::vector<Thing> cupboard{thing(4, 0, 0.5)};
  room.watch(0, 5, [&](double) { return std::vector<Thing>(cupboard); });
  for (double t = 5; t < 7; t += 1 / Room::kRate) room.look(t, cupboard, {0, 0}, M_PI);
  for (double t = 7; t < 10; t += 1 / Room::kRate) room.look(t, cupboard, {7.5, 0.2}, M_PI);
  const ObjectState found = room.only();
  EXPECT_EQ(found.number, 1);
  EXPECT_LT(found.still_since, 0.5);
  EXPECT_NEAR(found.box.sizes().x(), 0.5, 1.5 * kVoxel);
}

/// Somebody sits on a chair at first. They are one thing, until one of them gets up and goes.
TEST(ObjectFollower, WhoGetsUpFromAChairIsAnObjectOfTheirOwn) {
  Room room;
  const Thing chair = thing(5, -1, 0.5, 0.9);
  room.watch(0, 4.5, [&](double t) {
    return std::vector<Thing>{chair, thing(4.7, -0.9 + std::max(0.0, 0.7 * (t - 1.5)), 0.45)};
  });
  const std::vector<ObjectState> found = room.objects();
  ASSERT_EQ(found.size(), 2U);
  const size_t walker = found[0].is_moving ? 0 : 1;
  EXPECT_LT((found[walker].box.center().head<2>() - Eigen::Vector2d(4.7, 1.15)).norm(), 0.25);
  EXPECT_FALSE(found[1 - walker].is_moving);
  EXPECT_LT((found[1 - walker].box.center().head<2>() - Eigen::Vector2d(5, -1)).norm(), 0.35);
}

/// It stood for long. So its old places have been seen often, and must go nevertheless.
TEST(ObjectFollower, AThingThatIsPushedOutOfViewHasItsNewBox) {
  Room room;
  room.watch(0, 20, [](double) { return std::vector<Thing>{thing(4, 0)}; });
  for (double t = 20; t < 22; t += 1 / Room::kRate) room.look(t, {}, {0, 0}, M_PI);
  room.watch(22, 24, [](double) { return std::vector<Thing>{thing(4, 0.25)}; });
  const ObjectState found = room.only();
  EXPECT_EQ(found.number, 1);
  EXPECT_LT(std::abs(found.box.center().y() - 0.25), kVoxel);
}

/// An image a second, as on small computers.
TEST(ObjectFollower, FollowsInSlowImages) {
  Room room;
  for (int t = 0; t < 8; ++t) room.look(t, {thing(4, -1.2 + 0.3 * t)});
  const ObjectState found = room.only();
  EXPECT_EQ(found.number, 1);
  EXPECT_TRUE(found.is_moving);
  EXPECT_LT((found.box.center().head<2>() - Eigen::Vector2d(4, 0.9)).norm(), 0.2);
}

/// A walker who has left is forgotten after a minute, although they stood at the end.
TEST(ObjectFollower, WalkersOutOfViewAreForgotten) {
  Room room;
  room.watch(0, 4,
             [](double t) { return std::vector<Thing>{thing(4, -1 + 0.7 * std::min(t, 2.0))}; });
  ASSERT_FALSE(room.only().is_moving);
  for (double t = 4; t < 62; t += 1) room.look(t, {}, {0, 0}, M_PI);
  EXPECT_EQ(room.objects().size(), 1U);
  for (double t = 62; t < 66; t += 1) room.look(t, {}, {0, 0}, M_PI);
  EXPECT_TRUE(room.objects().empty());
}

/// Who has walked may be anywhere by now.
TEST(ObjectFollower, OutOfViewThePlaceOfAWalkerIsUncertain) {
  Room room;
  const auto walker = [](double t) { return std::vector<Thing>{thing(4, -1 + 0.7 * t)}; };
  room.watch(0, 2, walker);
  EXPECT_LT(room.only().position_sigma, 0.15);
  for (double t = 2; t < 5; t += 1 / Room::kRate) room.look(t, {}, {0, 0}, M_PI);
  EXPECT_GT(room.only().position_sigma, 4);
  EXPECT_EQ(room.only().velocity, Eigen::Vector3d::Zero());
}

/// One walks past in front of the other, 1 m nearer, and hides it for a moment.
TEST(ObjectFollower, NumbersStayWhenOneIsHidden) {
  Room room;
  const Thing chair = thing(5, 0, 0.5, 0.9);
  const auto things = [&](double t) {
    return std::vector<Thing>{chair, thing(3.5, -1.5 + 0.75 * t, 0.45)};
  };
  room.watch(0, 1, things);
  ASSERT_EQ(room.objects().size(), 2U);
  const size_t walker = room.objects()[0].box.center().x() < 4.3 ? 0 : 1;
  room.watch(1, 4, things);
  const std::vector<ObjectState> found = room.objects();  // in the order of their numbers
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[1].number, 2);
  EXPECT_TRUE(found[walker].is_moving);
  EXPECT_LT((found[walker].box.center().head<2>() - Eigen::Vector2d(3.5, 1.45)).norm(), 0.2);
  EXPECT_FALSE(found[1 - walker].is_moving);
  EXPECT_LT((found[1 - walker].box.center().head<2>() - Eigen::Vector2d(5, 0)).norm(), 0.3);
}

TEST(ObjectFollower, NoPointsAndNoImagesAreNoObjects) {
  ObjectFollower objects;
  objects.update(0, {}, {}, nullptr, {});
  EXPECT_TRUE(objects.objects(0).empty());
  Room room;
  room.look(0, {});
  room.look(0.1, {thing(4, 0)});
  EXPECT_TRUE(room.objects().empty()) << "one image proves nothing";
}

}  // namespace
}  // namespace edge_mcl
