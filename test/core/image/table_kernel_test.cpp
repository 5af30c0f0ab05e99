#include "edge_mcl/core/image/table_kernel.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

namespace edge_mcl {
namespace {

constexpr uint8_t kUntouched = 0xa5;
constexpr size_t kAfter =
    64;  // elements after a row that must not be written; longer than a vector

std::vector<uint8_t> randomBytes(size_t count, int most, std::mt19937* random) {
  std::vector<uint8_t> bytes(count);
  std::uniform_int_distribution<int> any(0, most);
  for (uint8_t& b : bytes) b = static_cast<uint8_t>(any(*random));
  return bytes;
}

/// Lengths shorter than a vector, around multiples of all widths of vectors, and of an image.
constexpr size_t kLengths[] = {0, 1, 7, 8, 15, 16, 17, 31, 32, 33, 63, 64, 65, 127, 128, 129, 640};

/// The truth is the formula in the header, computed with whole numbers.
TEST(TableKernel, RelaxRowAgreesWithItsFormula) {
  std::mt19937 random(1);
  for (const int none : {1, 25, 201, 254})
    for (const size_t count : kLengths) {
      const std::vector<uint8_t> source = randomBytes(count, none, &random);
      std::vector<uint8_t> target = randomBytes(count, none, &random);
      std::vector<uint8_t> expected = target;
      for (size_t i = 0; i < count; ++i)
        expected[i] =
            static_cast<uint8_t>(std::min(int{target[i]}, std::min(int{source[i]} + 1, none)));
      target.resize(count + kAfter, kUntouched);
      expected.resize(count + kAfter, kUntouched);
      relaxRow(source.data(), static_cast<uint8_t>(none), target.data(), count);
      EXPECT_EQ(target, expected) << "none " << none << ", count " << count;
    }
}

/// Tables of at most 32 entries have code of their own, so both sides of this number are tried.
TEST(TableKernel, EveryElementIsLookedUpInTheTableOfItsCell) {
  std::mt19937 random(2);
  for (const size_t entries : {size_t{2}, size_t{16}, size_t{17}, size_t{26}, size_t{32},
                               size_t{33}, size_t{202}, size_t{256}})
    for (const size_t cells : {size_t{0}, size_t{1}, size_t{2}, size_t{7}, size_t{80}}) {
      std::vector<std::vector<uint8_t>> tables;
      std::vector<const uint8_t*> table_of_cell;
      for (size_t c = 0; c < cells; ++c)
        tables.push_back(randomBytes(std::max(entries, size_t{32}), 255, &random));
      table_of_cell.reserve(cells);
      for (const auto& table : tables) table_of_cell.push_back(table.data());
      const std::vector<uint8_t> in =
          randomBytes(8 * cells, static_cast<int>(entries) - 1, &random);
      std::vector<uint8_t> out(8 * cells + kAfter, kUntouched), expected = out;
      for (size_t i = 0; i < 8 * cells; ++i) expected[i] = tables[i / 8][in[i]];
      lookUpByCell(in.data(), table_of_cell.data(), entries, cells, out.data());
      EXPECT_EQ(out, expected) << entries << " entries, " << cells << " cells";
    }
}

TEST(TableKernel, InterleavingPutsTheFirstRowIntoLowBytes) {
  std::mt19937 random(3);
  for (const size_t count : kLengths) {
    const std::vector<uint8_t> low = randomBytes(count, 255, &random);
    const std::vector<uint8_t> high = randomBytes(count, 255, &random);
    std::vector<uint16_t> out(count + kAfter, 0xa5a5), expected = out;
    for (size_t i = 0; i < count; ++i) expected[i] = static_cast<uint16_t>(low[i] + 256 * high[i]);
    interleaveRow(low.data(), high.data(), count, out.data());
    EXPECT_EQ(out, expected) << count;
  }
}

}  // namespace
}  // namespace edge_mcl
