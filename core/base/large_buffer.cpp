#include "edge_mcl/core/base/large_buffer.h"

#include <cstdlib>
#include <mutex>
#include <new>
#include <vector>

#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace edge_mcl {

namespace {

constexpr size_t kHugePage = size_t{1} << 21, kSmall = 64;
/// More than any machine has; rounding it up does not overflow.
constexpr size_t kLargest = size_t{1} << 60;

size_t alignmentOf(size_t bytes) { return bytes >= kHugePage ? kHugePage : kSmall; }

size_t roundedUp(size_t bytes) {
  const size_t alignment = alignmentOf(bytes);
  return (bytes + alignment - 1) / alignment * alignment;
}

/// Blocks that were given back, oldest first.
struct Store {
  static constexpr size_t kMost = 16;
  struct Block {
    void* memory;
    size_t bytes;
  };
  std::mutex mutex;
  std::vector<Block> blocks;
};

/// The store is never destroyed, because buffers may be given back while the program ends.
Store& store() {
  static Store* const kStore = new Store;
  return *kStore;
}

}  // namespace

void* takeLargeBlock(size_t bytes) {
  if (bytes > kLargest) throw std::bad_alloc();
  bytes = roundedUp(bytes);
  {
    Store& s = store();
    const std::lock_guard<std::mutex> lock(s.mutex);
    for (auto block = s.blocks.rbegin(); block != s.blocks.rend(); ++block)
      if (block->bytes == bytes) {
        void* memory = block->memory;
        s.blocks.erase(std::next(block).base());
        return memory;
      }
  }
  const size_t alignment = alignmentOf(bytes);
  void* memory = std::aligned_alloc(alignment, bytes);
  if (!memory) throw std::bad_alloc();
#if defined(__linux__)
  if (alignment == kHugePage) madvise(memory, bytes, MADV_HUGEPAGE);
#endif
  return memory;
}

void giveLargeBlock(void* block, size_t bytes) {
  void* oldest = nullptr;
  {
    Store& s = store();
    const std::lock_guard<std::mutex> lock(s.mutex);
    s.blocks.push_back({block, roundedUp(bytes)});
    if (s.blocks.size() > Store::kMost) {
      oldest = s.blocks.front().memory;
      s.blocks.erase(s.blocks.begin());
    }
  }
  std::free(oldest);
}

}  // namespace edge_mcl
