#include "edge_mcl/core/base/large_buffer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <limits>
#include <new>
#include <set>
#include <thread>
#include <utility>
#include <vector>

namespace edge_mcl {
namespace {

constexpr size_t kMegabyte = size_t{1} << 20;

TEST(LargeBlocks, ABlockThatWasGivenBackIsUsedAgain) {
  constexpr size_t kBytes = 7 * kMegabyte;
  void* const block = takeLargeBlock(kBytes);
  giveLargeBlock(block, kBytes);
  void* const again = takeLargeBlock(kBytes);
  EXPECT_EQ(again, block);
  void* const second = takeLargeBlock(kBytes);  // the first one is in use
  EXPECT_NE(second, block);
  giveLargeBlock(again, kBytes);
  giveLargeBlock(second, kBytes);
}

TEST(LargeBlocks, ABlockOfAnotherSizeIsNotUsed) {
  constexpr size_t kSmaller = 3 * kMegabyte, kLarger = 9 * kMegabyte;
  void* const smaller = takeLargeBlock(kSmaller);
  giveLargeBlock(smaller, kSmaller);
  void* const larger = takeLargeBlock(kLarger);
  EXPECT_NE(larger, smaller);
  // The whole block can be written.
  std::fill_n(static_cast<char*>(larger), kLarger, 'x');
  giveLargeBlock(larger, kLarger);
}

/// The test gives 17 blocks back. The store must keep the 16 youngest ones, so the next 16 blocks
/// must be these.
TEST(LargeBlocks, TheStoreKeepsSixteenBlocks) {
  constexpr size_t kBytes = 192 * 1024, kKept = 16;
  std::vector<void*> blocks;
  for (size_t i = 0; i <= kKept; ++i) blocks.push_back(takeLargeBlock(kBytes));
  for (void* block : blocks) giveLargeBlock(block, kBytes);
  const std::set<void*> youngest(blocks.begin() + 1, blocks.end());
  std::set<void*> taken;
  for (size_t i = 0; i < kKept; ++i) taken.insert(takeLargeBlock(kBytes));
  EXPECT_EQ(taken, youngest);
  for (void* block : taken) giveLargeBlock(block, kBytes);
}

/// Huge pages of x86-64 and of most ARM systems have 2 MiB. A block that does not begin on their
/// boundary would partly lie on small pages.
TEST(LargeBlocks, LargeOnesBeginOnHugePages) {
  for (const size_t bytes : {2 * kMegabyte, 2 * kMegabyte + 1, 5 * kMegabyte}) {
    void* const block = takeLargeBlock(bytes);
    EXPECT_EQ(reinterpret_cast<uintptr_t>(block) % (2 * kMegabyte), 0u) << bytes;
    giveLargeBlock(block, bytes);
  }
}

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kOwnAllocator = true;
#else
constexpr bool kOwnAllocator = false;
#endif

/// No system has half of all addresses free.
TEST(LargeBlocks, WithoutMemoryTheErrorIsBadAlloc) {
  if (kOwnAllocator) GTEST_SKIP() << "the allocator of a sanitizer ends the program instead";
  EXPECT_THROW(takeLargeBlock(std::numeric_limits<size_t>::max() / 2), std::bad_alloc);
}

/// The size is rounded up to whole huge pages. For the largest sizes this overflows to 0, and a
/// block without memory is returned instead of the error.
TEST(LargeBlocks, TheLargestSizeIsBadAlloc) {
  EXPECT_THROW(takeLargeBlock(std::numeric_limits<size_t>::max()), std::bad_alloc);
}

/// Every thread fills its block with its own number. A block that two threads get at the same time
/// shows the wrong number.
TEST(LargeBlocks, ThreadsNeverShareABlock) {
  constexpr size_t kBytes = 64 * 1024;
  std::atomic<int> faults{0};
  std::vector<std::thread> threads;
  for (int number = 1; number <= 4; ++number)
    threads.emplace_back([number, &faults] {
      for (int round = 0; round < 500; ++round) {
        auto* const block = static_cast<unsigned char*>(takeLargeBlock(kBytes));
        std::fill_n(block, kBytes, static_cast<unsigned char>(number));
        std::this_thread::yield();
        faults += std::any_of(block, block + kBytes, [&](unsigned char c) { return c != number; });
        giveLargeBlock(block, kBytes);
      }
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(faults, 0);
}

TEST(LargeBuffer, HoldsItsNumbers) {
  constexpr size_t kSize = 1000003;
  LargeBuffer<int32_t> buffer(kSize);
  ASSERT_EQ(buffer.size(), kSize);
  for (size_t i = 0; i < kSize; ++i) buffer[i] = static_cast<int32_t>(3 * i);
  const LargeBuffer<int32_t>& read = buffer;
  for (size_t i = 0; i < kSize; ++i) ASSERT_EQ(read[i], static_cast<int32_t>(3 * i));
  EXPECT_EQ(&read[kSize - 1], read.data() + kSize - 1);
}

TEST(LargeBuffer, WithoutElementsThereIsNoMemory) {
  EXPECT_EQ(LargeBuffer<float>().data(), nullptr);
  EXPECT_EQ(LargeBuffer<float>().size(), 0u);
  EXPECT_EQ(LargeBuffer<float>(0).data(), nullptr);
}

TEST(LargeBuffer, AMovedBufferKeepsItsMemory) {
  LargeBuffer<float> first(100000);
  first[99999] = 5;
  const float* const data = first.data();
  LargeBuffer<float> second(std::move(first));
  EXPECT_EQ(second.data(), data);
  EXPECT_EQ(second.size(), 100000u);
  LargeBuffer<float> third(7);
  third = std::move(second);
  EXPECT_EQ(third.data(), data);
  EXPECT_EQ(third[99999], 5);
}

/// A table of an image goes back to the store at the end of its life. The table of the next image
/// gets the same memory.
TEST(LargeBuffer, TheNextBufferOfTheSameSizeGetsItsMemory) {
  constexpr size_t kSize = 1234567;
  const double* first = nullptr;
  {
    const LargeBuffer<double> buffer(kSize);
    first = buffer.data();
  }
  EXPECT_EQ(LargeBuffer<double>(kSize).data(), first);
}

}  // namespace
}  // namespace edge_mcl
