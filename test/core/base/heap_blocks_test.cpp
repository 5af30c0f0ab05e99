#include "edge_mcl/core/base/heap_blocks.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>
#include <fstream>
#include <vector>

namespace edge_mcl {
namespace {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kOwnAllocator = true;
#else
constexpr bool kOwnAllocator = false;
#endif

/// Memory of this process that is in use, in megabytes, as the system counts it (proc(5)).
double residentMegabytes() {
  std::ifstream file("/proc/self/statm");
  double total = 0, resident = 0;
  file >> total >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE)) / 1e6;
}

/// Allocates pictures of 1 MB with an alignment, and frees them. A small block after every picture
/// stays in use, so the heap cannot shrink at its end.
/// @return memory in megabytes that the process keeps.
double keptAfterPictures() {
  constexpr int kPictures = 100;
  constexpr size_t kBytes = 1000000, kAlignment = 64;
  // By default glibc learns from the first large block that is freed (mallopt(3),
  // M_MMAP_THRESHOLD). It then puts blocks of this size into the heap.
  void* first = nullptr;
  if (posix_memalign(&first, kAlignment, 2 * kBytes) != 0) return 1e9;
  std::free(first);
  std::vector<void*> pictures(kPictures), small(kPictures);
  const double before = residentMegabytes();
  for (int i = 0; i < kPictures; ++i) {
    if (posix_memalign(&pictures[i], kAlignment, kBytes) != 0) return 1e9;
    std::memset(pictures[i], i, kBytes);
    small[i] = std::malloc(1000);
    std::memset(small[i], i, 1000);
  }
  for (void* picture : pictures) std::free(picture);
  const double kept = residentMegabytes() - before;
  for (void* block : small) std::free(block);
  return kept;
}

/// The setting holds for a whole program, so it is tried in a process of its own. The pictures have
/// 100 MB. The small blocks and the bookkeeping of the heap need less than 5 MB.
TEST(HeapBlocks, FreedPicturesGoBackToTheSystem) {
#ifndef __GLIBC__
  GTEST_SKIP() << "only glibc has the setting";
#endif
  if (kOwnAllocator) GTEST_SKIP() << "a sanitizer has its own allocator";
  testing::FLAGS_gtest_death_test_style = "threadsafe";
  EXPECT_EXIT(
      {
        giveLargeBlocksBack();
        const double kept = keptAfterPictures();
        std::fprintf(stderr, "%.1f MB are kept\n", kept);
        std::_Exit(kept < 5 ? 0 : 1);
      },
      testing::ExitedWithCode(0), "MB are kept");
}

}  // namespace
}  // namespace edge_mcl
