/// Owns CUDA memory, streams and events. For .cu files only.
#pragma once

#include <cuda_runtime.h>

#include <algorithm>
#include <string>
#include <utility>

#include "edge_mcl/gpu/engine/engine.h"

namespace edge_mcl::gpu {

/// @throws DeviceError with the name of the call, if the call failed.
inline void check(cudaError_t status, const char* call) {
  if (status == cudaSuccess) return;
  // Clear the error. Otherwise the next engine of this thread would report it at its first kernel.
  (void)cudaGetLastError();
  throw DeviceError(std::string("CUDA: ") + call + ": " + cudaGetErrorString(status));
}

/// Waits until the copies of DeviceArray have arrived on the device. cudaMemcpy returns as soon as
/// it has read the host's memory, and non-blocking streams may run before all data have arrived.
inline void finishCopies() {
  check(cudaStreamSynchronize(cudaStreamLegacy), "cudaStreamSynchronize");
}

/// Device array whose memory only grows. Growth keeps the contents.
template <class T>
class DeviceArray {
 public:
  DeviceArray() = default;
  ~DeviceArray() { cudaFree(data_); }
  DeviceArray(const DeviceArray&) = delete;
  DeviceArray& operator=(const DeviceArray&) = delete;

  void reserve(size_t count) {
    if (count <= capacity_) return;
    const size_t wanted = std::max(count, capacity_ + capacity_ / 2);
    T* fresh = nullptr;
    check(cudaMalloc(&fresh, wanted * sizeof(T)), "cudaMalloc");
    if (size_ > 0) {
      const cudaError_t status =
          cudaMemcpy(fresh, data_, size_ * sizeof(T), cudaMemcpyDeviceToDevice);
      if (status != cudaSuccess) cudaFree(fresh);
      check(status, "cudaMemcpy");
    }
    cudaFree(data_);
    data_ = fresh;
    capacity_ = wanted;
  }
  void resize(size_t count) {
    reserve(count);
    size_ = count;
  }
  /// Copies elements from the host to the end. Call finishCopies() before a kernel reads them.
  void append(const T* from, size_t count) {
    const size_t at = size_;
    reserve(at + count);
    if (count > 0)
      check(cudaMemcpy(data_ + at, from, count * sizeof(T), cudaMemcpyHostToDevice), "cudaMemcpy");
    size_ = at + count;
  }
  T* data() { return data_; }
  const T* data() const { return data_; }
  size_t size() const { return size_; }
  size_t bytes() const { return capacity_ * sizeof(T); }

 private:
  T* data_ = nullptr;
  size_t size_ = 0, capacity_ = 0;
};

/// Page-locked host array whose memory only grows. Growth loses the contents.
template <class T>
class PinnedArray {
 public:
  PinnedArray() = default;
  ~PinnedArray() { cudaFreeHost(data_); }
  PinnedArray(const PinnedArray&) = delete;
  PinnedArray& operator=(const PinnedArray&) = delete;

  void reserve(size_t count) {
    if (count <= capacity_) return;
    cudaFreeHost(data_);
    data_ = nullptr;
    capacity_ = 0;
    check(cudaMallocHost(&data_, count * sizeof(T)), "cudaMallocHost");
    capacity_ = count;
  }
  T* data() { return data_; }

 private:
  T* data_ = nullptr;
  size_t capacity_ = 0;
};

/// A CUDA stream that does not block on the default stream.
class Stream {
 public:
  Stream() {
    check(cudaStreamCreateWithFlags(&stream_, cudaStreamNonBlocking), "cudaStreamCreate");
  }
  ~Stream() { cudaStreamDestroy(stream_); }
  Stream(const Stream&) = delete;
  Stream& operator=(const Stream&) = delete;
  operator cudaStream_t() const { return stream_; }

 private:
  cudaStream_t stream_ = nullptr;
};

/// A CUDA event.
class Event {
 public:
  Event() { check(cudaEventCreate(&event_), "cudaEventCreate"); }
  ~Event() { cudaEventDestroy(event_); }
  Event(const Event&) = delete;
  Event& operator=(const Event&) = delete;
  operator cudaEvent_t() const { return event_; }

 private:
  cudaEvent_t event_ = nullptr;
};

}  // namespace edge_mcl::gpu
