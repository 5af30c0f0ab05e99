#include "edge_mcl/sim/renderer.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>
#include <vector>

#include "edge_mcl/core/base/random_source.h"
#include "support/scenes.h"

namespace edge_mcl {
namespace {

CameraModel cameraWith(DistortionModel model, int width = 160, int height = 120) {
  // This rational polynomial turns back at a radius of 0.87. Only a narrower field of view has an
  // inverse.
  const double focal = model == DistortionModel::kRationalPolynomial ? 0.9 : 0.7;
  return test::distorted(test::pinhole(width, height, focal * width), model);
}

class EveryDistortion : public testing::TestWithParam<DistortionModel> {};
INSTANTIATE_TEST_SUITE_P(All, EveryDistortion,
                         testing::Values(DistortionModel::kNone, DistortionModel::kPlumbBob,
                                         DistortionModel::kRationalPolynomial,
                                         DistortionModel::kEquidistant));

/// The truth is the projection by the camera model.
TEST_P(EveryDistortion, RaysProjectBackToTheirPixels) {
  const CameraModel camera = cameraWith(GetParam(), 640, 480);
  const CameraRays rays(camera);
  for (int y = 0; y < 480; ++y)
    for (int x = 0; x < 640; ++x) {
      Eigen::Vector2d pixel;
      const Eigen::Vector2f& ray = rays.at(x, y);
      ASSERT_TRUE(camera.project({ray.x(), ray.y(), 1}, &pixel)) << x << " " << y;
      ASSERT_NEAR((pixel - Eigen::Vector2d(x, y)).norm(), 0, 1e-3);  // single precision
    }
}

/// Seen from inside, a room consists of six planes. So the true depth of every pixel is known.
TEST_P(EveryDistortion, DepthIsThatOfTheWalls) {
  MeshSoup soup;
  const Eigen::Vector3f low(0, 0, 0), high(6, 5, 3);
  test::addBox(&soup, low, high, 0, true);
  const Scene scene(weldMesh(std::move(soup), 1e-6, "box"));
  const CameraModel camera = cameraWith(GetParam());
  const Renderer renderer(scene, camera, {});
  RandomSource random(5);
  double worst = 0;
  for (int k = 0; k < 20; ++k) {
    const Pose pose = test::lookAlong(
        {1 + 4 * random.uniform(), 1 + 3 * random.uniform(), 0.5 + 2 * random.uniform()},
        random.direction());
    const RenderedImage image = renderer.render(pose);
    for (int y = 0; y < camera.height; y += 3)
      for (int x = 0; x < camera.width; x += 3) {
        Eigen::Vector2d ray;
        ASSERT_TRUE(unproject(camera, {x, y}, &ray));
        const Eigen::Vector3d d = pose.linear() * Eigen::Vector3d(ray.x(), ray.y(), 1);
        double expected = 1e9;
        for (int axis = 0; axis < 3; ++axis) {
          const double wall = d[axis] > 0 ? high[axis] : low[axis];
          if (std::abs(d[axis]) > 1e-12)
            expected = std::min(expected, (wall - pose.translation()[axis]) / d[axis]);
        }
        worst = std::max(worst, std::abs(image.depth.at<float>(y, x) - expected) / expected);
        ASSERT_EQ(image.object.at<uint16_t>(y, x), 0);
      }
  }
  // 5 mm at 3 m are required. Single precision of coordinates in a room gives micrometres.
  EXPECT_LT(worst, 1e-4);
}

/// The camera model projects the border of a square. The pixels of the object must begin there.
TEST_P(EveryDistortion, ObjectsBeginWhereTheyAreProjected) {
  MeshSoup room, square;
  test::addBox(&room, {-5, -5, -5}, {5, 5, 5}, 0, true);
  square.vertices = {{-0.8f, -0.6f, 0}, {0.8f, -0.6f, 0}, {0.8f, 0.6f, 0}, {-0.8f, 0.6f, 0}};
  square.triangles = {{0, 1, 2}, {0, 2, 3}};
  square.triangle_material = {0, 0};
  Scene scene(weldMesh(std::move(room), 1e-6, "room"));
  const size_t number = scene.addObject(weldMesh(std::move(square), 1e-6, "square"));
  const Pose placed = Pose(Eigen::Translation3d(0.1, -0.05, 2.1)) *
                      Eigen::AngleAxisd(0.4, Eigen::Vector3d(0.3, 1, 0.5).normalized());
  scene.place(number, placed);
  scene.commit();
  const CameraModel camera = cameraWith(GetParam(), 640, 480);
  const RenderedImage image = Renderer(scene, camera, {}).render(Pose::Identity());
  const Eigen::Vector2d corner[4] = {{-0.8, -0.6}, {0.8, -0.6}, {0.8, 0.6}, {-0.8, 0.6}};
  for (int side = 0; side < 4; ++side)
    for (int i = 1; i < 200; ++i) {
      const double t = i / 200.0;
      const Eigen::Vector2d at = (1 - t) * corner[side] + t * corner[(side + 1) % 4];
      const auto pixelOf = [&](const Eigen::Vector2d& p) {
        Eigen::Vector2d pixel;
        EXPECT_TRUE(camera.project(placed * Eigen::Vector3d(p.x(), p.y(), 0), &pixel));
        return pixel;
      };
      const Eigen::Vector2d border = pixelOf(at), inside = pixelOf(0.98 * at);
      const Eigen::Vector2d towards = (inside - border).normalized();
      // The centre of the nearest pixel is up to 0.71 px away from a point. So 1.5 px from the
      // border the answer is certain when corners have an error of at most 0.5 px.
      const auto objectAt = [&](const Eigen::Vector2d& p) {
        return image.object.at<uint16_t>(static_cast<int>(std::lround(p.y())),
                                         static_cast<int>(std::lround(p.x())));
      };
      const Eigen::Vector2d in = border + 1.5 * towards, out = border - 1.5 * towards;
      if (t > 0.02 && t < 0.98) {
        EXPECT_EQ(objectAt(in), number + 1) << side << " " << t;
      }
      EXPECT_EQ(objectAt(out), 0) << side << " " << t;
    }
}

/// Fits y = a + b t + c t^2 to points, by least squares.
Eigen::Vector3d parabolaThrough(const std::vector<Eigen::Vector2d>& points) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const Eigen::Vector2d& p : points) {
    const Eigen::Vector3d row(1, p.x(), p.x() * p.x());
    normal += row * row.transpose();
    right += row * p.y();
  }
  return normal.ldlt().solve(right);
}

/// Finds the corners that the picture shows. The borders of the sides are found to sub-pixels by
/// coverage, fitted by parabolas, because distortion bends them, and intersected. The truth is the
/// projection by the camera model.
TEST_P(EveryDistortion, RenderedCornersAreWhereTheyAreProjected) {
  MeshSoup room, square;
  test::addBox(&room, {-5, -5, -5}, {5, 5, 5}, 0, true);
  room.material_colors = {Eigen::Vector3f::Zero()};
  square.vertices = {{-0.8f, -0.6f, 0}, {0.8f, -0.6f, 0}, {0.8f, 0.6f, 0}, {-0.8f, 0.6f, 0}};
  square.triangles = {{0, 1, 2}, {0, 2, 3}};
  square.triangle_material = {0, 0};
  square.material_colors = {Eigen::Vector3f::Ones()};
  Scene scene(weldMesh(std::move(room), 1e-6, "room"));
  const size_t number = scene.addObject(weldMesh(std::move(square), 1e-6, "square"));
  const Pose placed = Pose(Eigen::Translation3d(0.02, -0.01, 1.6)) *
                      Eigen::AngleAxisd(0.15, Eigen::Vector3d(0.5, 1, 0.4).normalized());
  scene.place(number, placed);
  scene.commit();
  Lighting even;
  even.ambient = 0.8;
  even.lamps = {{0, 0, 100}};  // behind the square, so that all its pixels are equally bright
  const CameraModel camera = cameraWith(GetParam(), 640, 480);
  const RenderedImage image = Renderer(scene, camera, even).render(Pose::Identity());
  const double full = image.color.at<cv::Vec3b>(240, 320)[1];
  const auto coverage = [&](int x, int y) { return image.color.at<cv::Vec3b>(y, x)[1] / full; };
  for (const double right : {-1.0, 1.0})
    for (const double down : {-1.0, 1.0}) {
      Eigen::Vector2d corner;
      ASSERT_TRUE(camera.project(placed * Eigen::Vector3d(0.8 * right, 0.6 * down, 0), &corner));
      const auto cx = static_cast<int>(corner.x()), cy = static_cast<int>(corner.y());
      ASSERT_TRUE(cx > 15 && cy > 15 && cx < 624 && cy < 464);
      // Points of the sides, relative to (cx, cy): along the side, across the side.
      std::vector<Eigen::Vector2d> horizontal, vertical;
      for (int k = 4; k < 30; ++k) {
        const int x = cx - static_cast<int>(right) * k, y = cy - static_cast<int>(down) * k;
        double below = 0, beside = 0;  // lengths that the square covers within ten pixels
        for (int j = -10; j <= 10; ++j) {
          below += coverage(x, cy + j);
          beside += coverage(cx + j, y);
        }
        // On the side of the square, everything from the border to the end of the window is
        // covered.
        horizontal.emplace_back(x - cx, down * (below - 10.5));
        vertical.emplace_back(y - cy, right * (beside - 10.5));
      }
      const Eigen::Vector3d h = parabolaThrough(horizontal), v = parabolaThrough(vertical);
      Eigen::Vector2d found(0, 0);
      for (int i = 0; i < 20; ++i) {
        found.y() = h[0] + found.x() * (h[1] + found.x() * h[2]);
        found.x() = v[0] + found.y() * (v[1] + found.y() * v[2]);
      }
      // Half a pixel is required. Rays on a grid of quarters show a border with an error of up to
      // an eighth of a pixel. Along a side that is parallel to the rows of pixels, this error is
      // the same everywhere. Four pixels outside its points a parabola has an error of up to twice
      // that. Two sides together give 0.35.
      found += Eigen::Vector2d(cx, cy);
      EXPECT_LT((found - corner).norm(), 0.35) << right << " " << down;
    }
}

/// The truth is the area and the centre of a square to sub-pixels. The coverage of the border
/// pixels must give both.
TEST(Renderer, OutlinesAreSmoothedByTheirCoverage) {
  MeshSoup room, square;
  test::addBox(&room, {-5, -5, -5}, {5, 5, 5}, 0, true);
  room.material_colors = {Eigen::Vector3f::Zero()};
  square.vertices = {{-0.5f, -0.4f, 2}, {0.53f, -0.4f, 2}, {0.53f, 0.41f, 2}, {-0.5f, 0.41f, 2}};
  square.triangles = {{0, 1, 2}, {0, 2, 3}};
  square.triangle_material = {0, 0};
  square.material_colors = {Eigen::Vector3f::Ones()};
  Scene scene(weldMesh(std::move(room), 1e-6, "room"));
  scene.addObject(weldMesh(std::move(square), 1e-6, "square"));
  Lighting even;
  even.ambient = 0.8;  // the lamp is behind the square, so all of it is equally bright
  even.lamps = {{0, 0, 100}};
  const CameraModel camera = test::pinhole(320, 240, 230);
  const RenderedImage image = Renderer(scene, camera, even).render(Pose::Identity());
  const double full = image.color.at<cv::Vec3b>(120, 160)[1];
  double area = 0, x_sum = 0, y_sum = 0;
  for (int y = 0; y < 240; ++y)
    for (int x = 0; x < 320; ++x) {
      const double share = image.color.at<cv::Vec3b>(y, x)[1] / full;
      area += share;
      x_sum += share * x;
      y_sum += share * y;
    }
  const double width = camera.fx * 1.03 / 2, height = camera.fy * 0.81 / 2;
  // Sixteen rays on a grid of quarters show a straight border with an error of up to an eighth of a
  // pixel. Four borders around 110 x 90 pixels give an error of two thousandths of the area.
  EXPECT_NEAR(area / (width * height), 1, 3e-3);
  EXPECT_NEAR(x_sum / area, camera.cx + camera.fx * 0.015 / 2, 0.1);
  EXPECT_NEAR(y_sum / area, camera.cy + camera.fy * 0.005 / 2, 0.1);
}

/// Finds the object of the nearest triangle on a ray, by Moeller and Trumbore, in double precision.
/// @param margin gets the smallest distance of the ray from the border of any triangle, in
/// barycentric coordinates @return number of the part; -1: none
int nearestObject(const std::vector<std::pair<const MeshModel*, Pose>>& parts,
                  const Eigen::Vector3d& eye, const Eigen::Vector3d& d, double* margin) {
  double nearest = 1e9;
  int object = -1;
  *margin = 1e9;  // no border has been met yet
  for (size_t k = 0; k < parts.size(); ++k)
    for (const auto& t : parts[k].first->triangles) {
      const auto corner = [&](int i) {
        return (parts[k].second * parts[k].first->vertices[t[i]].cast<double>()).eval();
      };
      const Eigen::Vector3d a = corner(0), e1 = corner(1) - a, e2 = corner(2) - a, h = d.cross(e2);
      const double det = e1.dot(h);
      if (std::abs(det) < 1e-12) continue;
      const Eigen::Vector3d s = eye - a, q = s.cross(e1);
      const double u = s.dot(h) / det, v = d.dot(q) / det, at = e2.dot(q) / det;
      if (at <= 0) continue;
      const double inside = std::min({u, v, 1 - u - v});
      *margin = std::min(*margin, std::abs(inside));
      if (inside >= 0 && at < nearest) {
        nearest = at;
        object = static_cast<int>(k);
      }
    }
  return object;
}

/// The truth is nearestObject(). Only rays on the border of a face may differ.
TEST(Renderer, ObjectNumbersAreThoseOfABruteForceSearch) {
  const MeshModel rooms = test::furnishedRooms(), column = test::column(9, 0.3f, 1.5f);
  Scene scene(rooms);
  const Pose at(Eigen::Translation3d(1.6, 2.2, 0.1));
  scene.place(scene.addObject(column), at);
  const Pose other =
      Pose(Eigen::Translation3d(2.4, 1.4, 0)) * Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitX());
  scene.place(scene.addObject(column), other);
  scene.commit();
  const CameraModel camera = cameraWith(DistortionModel::kPlumbBob, 80, 60);
  const Pose view = test::lookAlong({3.2, 2.5, 1.4}, {-1, -0.35, -0.25});
  const RenderedImage image = Renderer(scene, camera, {}).render(view);
  int seen[3] = {0, 0, 0}, unclear = 0;
  for (int y = 0; y < 60; ++y)
    for (int x = 0; x < 80; ++x) {
      Eigen::Vector2d ray;
      ASSERT_TRUE(unproject(camera, {x, y}, &ray));
      double margin = 0;
      const int object = nearestObject(
          {{&rooms, Pose::Identity()}, {&column, at}, {&column, other}}, view.translation(),
          view.linear() * Eigen::Vector3d(ray.x(), ray.y(), 1), &margin);
      ASSERT_GE(object, 0);
      ++seen[object];
      if (image.object.at<uint16_t>(y, x) == object) continue;
      ++unclear;
      EXPECT_LT(margin, 1e-5) << "a ray well inside a face";
    }
  EXPECT_GT(seen[1], 50);
  EXPECT_GT(seen[2], 50);
  EXPECT_LT(unclear, 5);
}

/// The truth is worked out by hand for a room of 4 x 4 x 3 m.
TEST(Scene, ClearanceIsTheDistanceToTheNearestFace) {
  MeshSoup soup;
  test::addBox(&soup, {0, 0, 0}, {4, 4, 3}, 0, true);
  const Scene scene(weldMesh(std::move(soup), 1e-6, "box"));
  EXPECT_NEAR(scene.clearance({1, 2, 1.5}, 10), 1, 1e-6);
  EXPECT_NEAR(scene.clearance({2, 2, 0.2}, 10), 0.2, 1e-6);
  EXPECT_NEAR(scene.clearance({-0.3, -0.4, 1}, 10), 0.5, 1e-6);  // outside, at an edge
  EXPECT_EQ(scene.clearance({2, 2, 1.5}, 0.5), 0.5);
  EXPECT_TRUE(scene.blocked({1, 1, 1}, {1, 1, 5}));
  EXPECT_FALSE(scene.blocked({1, 1, 1}, {3, 3, 2}));
}

}  // namespace
}  // namespace edge_mcl
