#include "edge_mcl/core/edges/visibility.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <thread>

#include "edge_mcl/core/base/random_source.h"
#include "edge_mcl/core/import/mesh_loader.h"
#include "support/scenes.h"

namespace edge_mcl {
namespace {

/// The truth is counted by hand: from a corner a box shows nine of its edges, from the middle of a
/// side four, from inside all twelve.
TEST(Visibility, OfABoxNineEdgesAreSeenFromACorner) {
  MeshSoup soup;
  test::addBox(&soup, {0, 0, 0}, {1, 1, 1});
  MeshModel mesh = weldMesh(soup, 1e-6, "box");
  const EdgeModel edges = buildEdgeModel(&mesh, {});
  const Visibility visibility(mesh, edges, {});
  EXPECT_EQ(visibility.exact({3, 4, 5}).group_count, 9u);
  EXPECT_EQ(visibility.exact({3, 0.5, 0.5}).group_count, 4u);
  EXPECT_EQ(visibility.exact({0.5, 0.5, 0.5}).group_count, 12u);  // from the inside
}

/// A board of 5 cm stands beside the surface of a thing that was added. The board hides its far
/// edges. The thing does not hide its own line, which depth has placed 5 cm behind the surface.
TEST(Visibility, OnlyLinesAreSeenThroughTheNoiseOfAddedSurfaces) {
  MeshSoup soup;
  test::addBox(&soup, {0, 0, 0}, {0.05f, 1, 1});
  soup.hides_only.assign(soup.triangles.size(), false);
  const auto first = static_cast<uint32_t>(soup.vertices.size());
  for (const float y : {2.f, 3.f})
    for (const float z : {0.f, 1.f}) soup.vertices.emplace_back(0, y, z);
  soup.triangles.push_back({first, first + 1, first + 2});
  soup.triangles.push_back({first + 1, first + 2, first + 3});
  soup.triangle_material.resize(soup.triangles.size(), 0);
  soup.hides_only.resize(soup.triangles.size(), true);
  for (const float x : {0.05f, 0.15f}) {  // the second one is behind the thing
    const auto start = static_cast<uint32_t>(soup.vertices.size());
    soup.vertices.emplace_back(x, 2.3f, 0.5f);
    soup.vertices.emplace_back(x, 2.7f, 0.5f);
    soup.lines.push_back({start, start + 1});
  }
  MeshModel mesh = weldMesh(soup, 1e-6, "board and thing");
  const EdgeModel edges = buildEdgeModel(&mesh, {});
  const Visibility visibility(mesh, edges, {});
  const VisibleSet seen = visibility.exact({-3, 0.5, 0.5});
  size_t lines = 0;
  for (const VisibleSet::Segment& segment : seen.segments) {
    const EdgeLine& line = seen.line(segment);
    const bool is_explicit = line.kind == EdgeKind::kLine;
    lines += is_explicit ? 1 : 0;
    EXPECT_NEAR(line.start.x(), is_explicit ? 0.05 : 0, 1e-6);
    EXPECT_NEAR(line.end.x(), is_explicit ? 0.05 : 0, 1e-6);
  }
  EXPECT_GT(lines, 0u);
}

using SampleKeys = std::set<std::pair<uint32_t, uint32_t>>;  // segment, sample

SampleKeys keysOf(const VisibleSet& set) {
  SampleKeys result;
  for (const auto& s : set.segments)
    for (uint32_t i = 0; i < EdgeSegment::kMaxSamples; ++i)
      if (s.samples >> i & 1u) result.insert({s.index, i});
  return result;
}

/// Whether a triangle lies between two points. Tries all triangles, with the intersection of T.
/// Moeller and B. Trumbore, "Fast, minimum storage ray/triangle intersection", 1997. @param before
/// length at the far end of the way that does not count, m
bool isHidden(const MeshModel& mesh, const Eigen::Vector3d& from, const Eigen::Vector3d& to,
              double before) {
  const Eigen::Vector3d way = to - from;
  return std::any_of(mesh.triangles.begin(), mesh.triangles.end(), [&](const auto& t) {
    const Eigen::Vector3d a = mesh.vertices[t[0]].template cast<double>();
    const Eigen::Vector3d u = mesh.vertices[t[1]].template cast<double>() - a;
    const Eigen::Vector3d v = mesh.vertices[t[2]].template cast<double>() - a;
    const Eigen::Vector3d p = way.cross(v);
    const double determinant = u.dot(p);
    if (std::abs(determinant) < 1e-12) return false;
    const Eigen::Vector3d s = from - a, q = s.cross(u);
    const double x = s.dot(p) / determinant, y = way.dot(q) / determinant;
    const double along = v.dot(q) / determinant;
    return x >= 0 && y >= 0 && x + y <= 1 && along > 0 && along < 1 - before / way.norm();
  });
}

/// The truth is isHidden(). Contours are left out, because their visibility does not depend on rays
/// alone.
TEST(Visibility, RaysTracedTogetherAgreeWithEveryTriangleTriedAlone) {
  MeshModel mesh = test::furnishedRooms();
  const EdgeModel edges = buildEdgeModel(&mesh, {});
  const Visibility visibility(mesh, edges, {});
  RandomSource random(11);
  size_t differ = 0, all = 0;
  for (int k = 0; k < 20; ++k) {
    const Eigen::Vector3d p(8 * random.uniform(), 5 * random.uniform(), 2.6 * random.uniform());
    const uint32_t thinning = 1 + k % 7;
    const SampleKeys seen = keysOf(visibility.exact(p, thinning));
    for (uint32_t s = 0; s < edges.segments.size(); ++s) {
      const EdgeSegment& segment = edges.segments[s];
      if (edges.lines[segment.line].kind == EdgeKind::kContour) continue;
      for (uint32_t i = 0; i < segment.sample_count; ++i) {
        if ((segment.first_sample + i) % thinning != 0) {
          EXPECT_EQ(seen.count({s, i}), 0u);
          continue;
        }
        ++all;
        differ += isHidden(mesh, p, edges.samplePosition(segment, i),
                           visibility.occlusionTolerance()) == (seen.count({s, i}) > 0);
      }
    }
  }
  // Rays that graze an edge may differ in single precision. These are a few in a thousand.
  EXPECT_GT(all, 5000u);
  EXPECT_LT(static_cast<double>(differ), 0.005 * static_cast<double>(all))
      << differ << " of " << all;
}

/// The hierarchy only leaves out what rays would find hidden. Every bit agrees with the search
/// through all segments.
TEST(Visibility, TheHierarchyLeavesOutNothingThatIsSeen) {
  std::vector<MeshModel> meshes;
  meshes.push_back(test::furnishedRooms());
  for (const char* name : {"office.obj", "house.obj", "hall.obj"})
    meshes.push_back(loadMesh(std::string(EDGE_MCL_MAPS) + "/" + name, {}));
  RandomSource random(13);
  for (MeshModel& mesh : meshes) {
    const EdgeModel edges = buildEdgeModel(&mesh, {});
    const Visibility visibility(mesh, edges, {});
    const Eigen::Vector3d low = mesh.lowest.cast<double>(), high = mesh.highest.cast<double>();
    for (int k = 0; k < 60; ++k) {
      // Also from outside of the building.
      Eigen::Vector3d p;
      for (int a = 0; a < 3; ++a) p[a] = low[a] - 0.5 + (high[a] - low[a] + 1) * random.uniform();
      const VisibleSet found = visibility.exact(p), truth = visibility.exhaustive(p);
      EXPECT_EQ(keysOf(found), keysOf(truth)) << p.transpose();
      EXPECT_EQ(found.group_count, truth.group_count);
    }
  }
}

TEST(SegmentTree, FindsEverySegmentOnceInOrder) {
  MeshModel mesh = test::furnishedRooms();
  const EdgeModel edges = buildEdgeModel(&mesh, {});
  const std::vector<uint32_t> all = SegmentTree(edges).find([](const Box&) { return true; });
  ASSERT_EQ(all.size(), edges.segments.size());
  for (uint32_t k = 0; k < all.size(); ++k) EXPECT_EQ(all[k], k);
}

/// A box that holds a segment holds its samples.
TEST(SegmentTree, BoxesHoldTheirSamples) {
  MeshModel mesh = test::furnishedRooms();
  const EdgeModel edges = buildEdgeModel(&mesh, {});
  const SegmentTree tree(edges);
  RandomSource random(3);
  for (int k = 0; k < 200; ++k) {
    const Eigen::Vector3d at(8 * random.uniform(), 5 * random.uniform(), 2.6 * random.uniform());
    const double radius = 0.1 + random.uniform();
    const std::vector<uint32_t> found = tree.find([&](const Box& box) {
      const Eigen::Array3d away =
          (at - box.centre.cast<double>()).array().abs() - box.half.cast<double>().array();
      return away.max(0.0).matrix().norm() <= radius + 1e-5;
    });
    for (uint32_t s = 0; s < edges.segments.size(); ++s)
      for (uint32_t i = 0; i < edges.segments[s].sample_count; ++i)
        if ((edges.samplePosition(edges.segments[s], i) - at).norm() < radius) {
          EXPECT_TRUE(std::binary_search(found.begin(), found.end(), s));
          break;
        }
  }
}

/// The visible set of a cone is compared with the visible set of all directions. Every sample in
/// the cone must be kept, and no other sample may be added.
TEST(Visibility, AConeLeavesOutWhatLiesOutsideAndNothingElse) {
  MeshModel mesh = test::furnishedRooms();
  const EdgeModel edges = buildEdgeModel(&mesh, {});
  const Visibility visibility(mesh, edges, {});
  RandomSource random(12);
  size_t in_cone = 0, kept = 0, all = 0;
  for (int k = 0; k < 200; ++k) {
    const Eigen::Vector3d p(8 * random.uniform(), 5 * random.uniform(), 2.6 * random.uniform());
    const Eigen::Vector3d axis = random.direction();
    const double angle = M_PI * random.uniform();
    const SampleKeys full = keysOf(visibility.exact(p));
    const SampleKeys some =
        keysOf(visibility.exact(p, 1, {axis.cast<float>(), static_cast<float>(angle)}));
    for (const auto& key : some) EXPECT_EQ(full.count(key), 1u);
    for (const auto& key : full) {
      const Eigen::Vector3d to = edges.samplePosition(edges.segments[key.first], key.second) - p;
      const double off = std::acos(std::clamp(axis.dot(to.normalized()), -1.0, 1.0));
      if (off > angle - 1e-3) continue;
      ++in_cone;
      EXPECT_EQ(some.count(key), 1u) << "at " << off << " of " << angle << " radians";
    }
    kept += some.size();
    all += full.size();
  }
  EXPECT_GT(in_cone, 1000u);
  // A segment that only touches the cone is kept as a whole.
  EXPECT_LT(kept, 0.75 * static_cast<double>(all));
}

/// Measures the share of samples whose cached visibility differs from exact rays, over random free
/// positions.
TEST(Visibility, CachedAgreesWithExactRays) {
  MeshModel mesh = test::furnishedRooms();
  const EdgeModel edges = buildEdgeModel(&mesh, {});
  const Visibility visibility(mesh, edges, {});
  RandomSource random(7);
  size_t differ = 0, visible = 0;
  int poses = 0;
  while (poses < 1000) {
    const Eigen::Vector3d p(8 * random.uniform(), 5 * random.uniform(), 2.6 * random.uniform());
    const auto insideBox = [&](double x0, double y0, double z0, double x1, double y1, double z1) {
      constexpr double kMargin = 0.2;  // a UAV keeps this far from furniture
      return p.x() > x0 - kMargin && p.x() < x1 + kMargin && p.y() > y0 - kMargin &&
             p.y() < y1 + kMargin && p.z() > z0 - kMargin && p.z() < z1 + kMargin;
    };
    if (insideBox(0.3, 0.2, 0, 1.9, 1, 1.2) || insideBox(2.9, 4.2, 0, 3.8, 4.9, 1.9) ||
        insideBox(5, 3.5, 0, 7, 4.4, 0.45) || insideBox(5.6, 0.3, 0, 6.4, 1.1, 0.72) ||
        insideBox(7.2, 1, 0, 7.8, 2.2, 1.4) || insideBox(3.95, 0, 0, 4.05, 5, 2.6) || p.x() < 0.2 ||
        p.x() > 7.8 || p.y() < 0.2 || p.y() > 4.8 || p.z() < 0.2 || p.z() > 2.4)
      continue;
    ++poses;
    const SampleKeys exact = keysOf(visibility.exact(p));
    const SampleKeys cached = keysOf(*visibility.cached(visibility.cellOf(p)));
    visible += exact.size();
    for (const auto& k : exact) differ += 1 - cached.count(k);
    for (const auto& k : cached) differ += 1 - exact.count(k);
  }
  const double share = static_cast<double>(differ) / static_cast<double>(visible);
  std::printf(
      "cached visibility differs from exact rays for %.2f %% of the visible samples "
      "(cell %.2f m)\n",
      100 * share, visibility.cellSize());
  RecordProperty("disagreement_percent", std::to_string(100 * share));
  EXPECT_LT(share, 0.02);
}

TEST(Visibility, TheCacheIsBoundedAndServesManyThreads) {
  MeshModel mesh = test::furnishedRooms();
  const EdgeModel edges = buildEdgeModel(&mesh, {});
  VisibilityParameters params;
  // Half of the twelve cells find room.
  const Visibility unbounded(mesh, edges, params);
  size_t all = 0;
  for (int i = 0; i < 12; ++i) all += unbounded.cached({10 + i, 10, 10})->bytes();
  params.cache_megabytes = 0.5e-6 * static_cast<double>(all);
  const Visibility visibility(mesh, edges, params);
  std::vector<std::thread> threads;
  threads.reserve(4);
  std::vector<size_t> sizes(4 * 50);
  for (int t = 0; t < 4; ++t)
    threads.emplace_back([&, t] {
      for (int i = 0; i < 50; ++i)
        sizes[t * 50 + i] = visibility.cached({10 + i % 12, 10, 10})->sample_count;
    });
  for (auto& thread : threads) thread.join();
  for (int i = 0; i < 200; ++i)
    EXPECT_EQ(sizes[i],
              visibility.exact(visibility.cellCentre({10 + i % 50 % 12, 10, 10})).sample_count);
  EXPECT_LE(visibility.statistics().bytes, all / 2);
  EXPECT_GE(visibility.statistics().cells, 2u);
  EXPECT_GT(visibility.statistics().dropped, 0u);
}

}  // namespace
}  // namespace edge_mcl
