#include "edge_mcl/core/places/search_places.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "edge_mcl/core/base/error.h"
#include "support/error_text.h"
#include "support/scenes.h"

namespace edge_mcl {
namespace {

/// A model with everything that the places of a search need.
struct Map {
  explicit Map(MeshModel m) : mesh(std::move(m)), edges(buildEdgeModel(&mesh, {})) {}
  SearchPlaces places(const SearchParameters& params) const {
    return SearchPlaces(space, visibility, params);
  }
  MeshModel mesh;
  EdgeModel edges;
  FreeSpace space{mesh, {0.2, 0.7}};
  Visibility visibility{mesh, edges, {}};
};

/// An empty room.
Map room(float x, float y, float z) {
  MeshSoup soup;
  test::addBox(&soup, {0, 0, 0}, {x, y, z}, 0, true);
  return Map(weldMesh(std::move(soup), 1e-6, "room"));
}

/// The room has 4 x 3 x 2.5 m. A grid of at most 0.5 m has 8 x 6 x 5 positions. They lie at least
/// 0.25 m from the walls, so all of them are free.
TEST(SearchPlaces, CoverTheFreeSpaceOfARoom) {
  SearchParameters params;
  params.place_spacing = 0.5;
  const Map map = room(4, 3, 2.5f);
  const SearchPlaces places = map.places(params);
  EXPECT_EQ(places.spacing, 0.5);
  ASSERT_EQ(places.places.size(), 8u * 6u * 5u);
  for (int x = 0; x < 8; ++x)
    for (int y = 0; y < 6; ++y)
      for (int z = 0; z < 5; ++z) {
        const Eigen::Vector3d expected(0.25 + 0.5 * x, 0.25 + 0.5 * y, 0.25 + 0.5 * z);
        int found = 0;
        for (const SearchPlaces::Place& place : places.places)
          found += (place.position - expected).norm() < 1e-6;  // corners in single precision
        EXPECT_EQ(found, 1) << expected.transpose();
      }
}

TEST(SearchPlaces, LieInTheFreeSpace) {
  const Map map(test::furnishedRooms());
  const SearchPlaces places = map.places({});
  EXPECT_GT(places.places.size(), 100u);
  for (const SearchPlaces::Place& place : places.places)
    EXPECT_TRUE(map.space.contains(place.position)) << place.position.transpose();
}

/// In the room with 20 x 15 x 8 m the spacing of 0.4 m would give 35000 places.
TEST(SearchPlaces, InALargeBuildingTheSpacingGrows) {
  SearchParameters params;
  params.max_places = 500;
  const Map map = room(20, 15, 8);
  const SearchPlaces places = map.places(params);
  EXPECT_NEAR(places.spacing, std::cbrt(map.space.volume() / 500), 1e-9);
  // The steps of the grid divide the room evenly, so they are up to a few per cent shorter than the
  // spacing. There are 14 x 11 x 6 cells, and the free volume is known to some per cent.
  EXPECT_LT(places.places.size(), 500u * 1.3);
  EXPECT_GT(places.places.size(), 500u * 0.7);
}

/// The visible sets must be those of the positions, with the thinning that the places name.
TEST(SearchPlaces, EveryPlaceHasItsVisibleSet) {
  const Map map(test::furnishedRooms());
  SearchParameters params;
  params.place_spacing = 0.9;
  const SearchPlaces places = map.places(params);
  EXPECT_EQ(places.thinning, SearchPlaces::thinningFor(map.edges));
  size_t seen = 0;
  for (const SearchPlaces::Place& place : places.places) {
    ASSERT_NE(place.visible, nullptr);
    const VisibleSet expected = map.visibility.exact(place.position, places.thinning);
    ASSERT_EQ(place.visible->segments.size(), expected.segments.size());
    for (size_t i = 0; i < expected.segments.size(); ++i) {
      EXPECT_EQ(place.visible->segments[i].index, expected.segments[i].index);
      EXPECT_EQ(place.visible->segments[i].samples, expected.segments[i].samples);
    }
    seen += place.visible->sample_count;
  }
  EXPECT_GT(seen, 100 * places.places.size());
}

/// In a pipe of 0.3 x 0.3 m every position is closer than 0.2 m to a wall.
TEST(SearchPlaces, WithoutAnyPlaceThereIsAnError) {
  const Map map = room(5, 0.3f, 0.3f);
  test::expectError<InputError>("search.clearance", [&] { map.places({}); });
}

/// Of n samples, the numbers that are multiples of the thinning remain. Whole thinnings cannot give
/// every number of samples: the number that remains is at least the number that is wanted, and less
/// than twice this number.
TEST(SearchPlaces, ThinningLeavesAboutTheWantedSamples) {
  EdgeModel model;
  for (const size_t samples : {1, 100, 2499, 2500, 4999, 5000, 123456}) {
    model.sample_along.resize(samples);
    for (const size_t wanted : {100, 2500}) {
      const uint32_t thinning = SearchPlaces::thinningTo(model, wanted);
      ASSERT_GE(thinning, 1u);
      const size_t left = (samples + thinning - 1) / thinning;
      EXPECT_GE(left, std::min(samples, wanted));
      EXPECT_LT(left, 2 * wanted);
    }
    EXPECT_EQ(SearchPlaces::thinningFor(model), SearchPlaces::thinningTo(model, 2500));
  }
}

}  // namespace
}  // namespace edge_mcl
