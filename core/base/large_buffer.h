/// Memory for per-image tables of several megabytes.
#pragma once

#include <cstddef>
#include <memory>
#include <type_traits>

namespace edge_mcl {

/// Returns a block of memory. It comes from a store of blocks that were given back, if one there
/// has the right size. The store keeps at most 16 blocks. Thread-safe.
/// @throws std::bad_alloc when memory runs out.
void* takeLargeBlock(size_t bytes);
/// Gives a block back to the store. Thread-safe. @param bytes as for takeLargeBlock().
void giveLargeBlock(void* block, size_t bytes);

/// Fixed-size array of numbers, not initialised. Large arrays lie on huge pages where the system
/// has them. The tables in them are made anew for every image and read at random. With small pages,
/// page faults and misses of the address translation cost a fifth of the time. For this reason the
/// memory is also used again instead of being returned to the system.
template <class T>
class LargeBuffer {
  static_assert(std::is_trivial_v<T>, "the memory is not initialised");

 public:
  LargeBuffer() = default;
  explicit LargeBuffer(size_t size) : size_(size) {
    const size_t bytes = size * sizeof(T);
    if (bytes > 0) data_ = {static_cast<T*>(takeLargeBlock(bytes)), GiveBack{bytes}};
  }
  T* data() { return data_.get(); }
  const T* data() const { return data_.get(); }
  size_t size() const { return size_; }
  T& operator[](size_t i) { return data_.get()[i]; }
  const T& operator[](size_t i) const { return data_.get()[i]; }

 private:
  struct GiveBack {
    size_t bytes = 0;
    void operator()(T* p) const { giveLargeBlock(p, bytes); }
  };
  std::unique_ptr<T, GiveBack> data_;
  size_t size_ = 0;
};

}  // namespace edge_mcl
