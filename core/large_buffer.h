/// Memory for per-image tables of several megabytes.
#pragma once

#include <cstddef>
#include <cstdlib>
#include <memory>
#include <new>
#include <type_traits>

#if defined(__linux__)
#include <sys/mman.h>
#endif

namespace edge_mcl {

/// Fixed-size array of numbers, not initialised. Large ones are put on huge pages where the system
/// has them: tables are made anew for every image and read at random, and with small pages the
/// faults and misses of the address translation cost a fifth of the time.
template <class T>
class LargeBuffer {
  static_assert(std::is_trivial_v<T>, "the memory is not initialised");

 public:
  LargeBuffer() = default;
  explicit LargeBuffer(size_t size) : size_(size) {
    constexpr size_t kHugePage = size_t{1} << 21, kSmall = 64;
    const size_t alignment = size * sizeof(T) >= kHugePage ? kHugePage : kSmall;
    const size_t bytes = (size * sizeof(T) + alignment - 1) / alignment * alignment;
    if (bytes == 0) return;
    data_.reset(static_cast<T*>(std::aligned_alloc(alignment, bytes)));
    if (!data_) throw std::bad_alloc();
#if defined(__linux__)
    if (alignment == kHugePage) madvise(data_.get(), bytes, MADV_HUGEPAGE);
#endif
  }
  T* data() { return data_.get(); }
  const T* data() const { return data_.get(); }
  size_t size() const { return size_; }
  T& operator[](size_t i) { return data_.get()[i]; }
  const T& operator[](size_t i) const { return data_.get()[i]; }

 private:
  struct Free {
    void operator()(T* p) const { std::free(p); }
  };
  std::unique_ptr<T, Free> data_;
  size_t size_ = 0;
};

}  // namespace edge_mcl
