#include "edge_mcl/core/likelihood/segment_union.h"

#include <gtest/gtest.h>

#include <random>
#include <set>
#include <vector>

namespace edge_mcl {
namespace {

/// The truth is a std::set. Sizes around multiples of 64 are tried, because a word has 64 bits.
TEST(SegmentUnion, IsASetWithRanks) {
  std::mt19937 random(4);
  for (const uint32_t size : {1u, 63u, 64u, 65u, 128u, 1000u})
    for (const uint32_t inserted : {0u, 1u, 20u, 3000u}) {
      SegmentUnion merged(size);
      std::set<uint32_t> truth;
      for (uint32_t i = 0; i < inserted; ++i) {
        const uint32_t index = std::uniform_int_distribution<uint32_t>(0, size - 1)(random);
        merged.insert(index);  // often not for the first time
        if (index % 3 != 0) truth.insert(index);
      }
      const std::vector<uint32_t> kept = merged.filter([](uint32_t k) { return k % 3 != 0; });
      EXPECT_EQ(kept, std::vector<uint32_t>(truth.begin(), truth.end()));
      std::vector<int32_t> expected(size, -1);
      for (size_t rank = 0; rank < kept.size(); ++rank)
        expected[kept[rank]] = static_cast<int32_t>(rank);
      for (uint32_t i = 0; i < size; ++i) EXPECT_EQ(merged.rank(i), expected[i]) << i;
    }
}

/// The function decides once about every number of the set, and about no other number.
TEST(SegmentUnion, AsksOnceAboutEveryNumber) {
  SegmentUnion merged(200);
  for (const uint32_t k : {199u, 0u, 64u, 63u, 64u}) merged.insert(k);
  std::vector<uint32_t> asked;
  merged.filter([&](uint32_t k) {
    asked.push_back(k);
    return true;
  });
  EXPECT_EQ(asked, (std::vector<uint32_t>{0, 63, 64, 199}));
}

/// A second filter removes more numbers, and ranks follow it.
TEST(SegmentUnion, CanBeFilteredAgain) {
  SegmentUnion merged(100);
  for (uint32_t k = 0; k < 100; ++k) merged.insert(k);
  merged.filter([](uint32_t k) { return k % 2 == 0; });
  const std::vector<uint32_t> kept = merged.filter([](uint32_t k) { return k >= 90; });
  EXPECT_EQ(kept, (std::vector<uint32_t>{90, 92, 94, 96, 98}));
  EXPECT_EQ(merged.rank(94), 2);
  EXPECT_EQ(merged.rank(10), -1);
}

}  // namespace
}  // namespace edge_mcl
