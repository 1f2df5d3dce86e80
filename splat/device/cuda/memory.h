// Memory of the device, owned and borrowed; and pinned memory, which the host shares with it.
#pragma once

#include <cassert>
#include <cstddef>
#include <utility>

#include "splat/device/buffer.h"
#include "splat/device/cuda/check.h"
#include "splat/math/namespace.h"

namespace cosplat::cuda {

// Pointer and count, for kernels. Indices are checked where asserts are compiled in.
template <class T>
struct DeviceView {
  T* data = nullptr;
  size_t count = 0;

  COSPLAT_HD T& operator[](size_t i) const {
    assert(i < count);
    return data[i];
  }
};

// Throws Error with how much was wanted and how much there is.
void* AllocateDevice(size_t bytes);

// Elements of any values. Grows as Refill (splat/device/buffer.h) does, never shrinks.
template <class T>
class DeviceBuffer {
 public:
  DeviceBuffer() = default;
  ~DeviceBuffer() { cudaFree(data_); }
  DeviceBuffer(DeviceBuffer&& other) noexcept { swap(other); }
  DeviceBuffer& operator=(DeviceBuffer&& other) noexcept {
    swap(other);
    return *this;
  }
  void swap(DeviceBuffer& other) noexcept {
    std::swap(data_, other.data_);
    std::swap(size_, other.size_);
    std::swap(capacity_, other.capacity_);
  }

  // n elements of any values; what was there is lost. Waits for the device where it has to grow.
  void Refill(size_t n) {
    if (n > capacity_) {
      Check(cudaFree(std::exchange(data_, nullptr)), "cudaFree");
      size_ = capacity_ = 0;
      // With room for a little more where sizes vary from view to view.
      const size_t roomy = n + n / kHeadRoom;
      data_ = static_cast<T*>(AllocateDevice(roomy * sizeof(T)));
      capacity_ = roomy;
    }
    size_ = n;
  }
  void FillWithZeros(cudaStream_t stream) {
    if (size_ != 0) Check(cudaMemsetAsync(data_, 0, size_ * sizeof(T), stream), "cudaMemsetAsync");
  }
  void Upload(const T* from, size_t n, cudaStream_t stream) {
    Refill(n);
    if (n != 0) Copy(data_, from, n, cudaMemcpyHostToDevice, stream);
  }
  // To [size()] elements; they are there when the stream has been waited for.
  void Download(T* to, cudaStream_t stream) const {
    if (size_ != 0) Copy(to, data_, size_, cudaMemcpyDeviceToHost, stream);
  }

  T* data() { return data_; }
  const T* data() const { return data_; }
  size_t size() const { return size_; }
  size_t capacity() const { return capacity_; }
  bool empty() const { return size_ == 0; }
  DeviceView<T> view() { return {data_, size_}; }
  DeviceView<const T> view() const { return {data_, size_}; }

 private:
  static void Copy(T* to, const T* from, size_t n, cudaMemcpyKind kind, cudaStream_t stream) {
    Check(cudaMemcpyAsync(to, from, n * sizeof(T), kind, stream), "cudaMemcpyAsync");
  }

  T* data_ = nullptr;
  size_t size_ = 0, capacity_ = 0;
};

// One value that the device tells the host.
template <class T>
class Readback {
 public:
  Readback() {
    void* p = nullptr;
    Check(cudaMallocHost(&p, sizeof(T)), "cudaMallocHost");
    value_ = static_cast<T*>(p);
  }
  ~Readback() { cudaFreeHost(value_); }
  Readback(const Readback&) = delete;
  Readback& operator=(const Readback&) = delete;
  // Reads what the device has after all that the stream was given so far: the host waits.
  const T& Get(const T* on_device, cudaStream_t stream) {
    Ask(on_device, stream);
    Check(cudaStreamSynchronize(stream), "cudaStreamSynchronize");
    return *value_;
  }
  // Without waiting: Last has it once the stream was waited for.
  void Ask(const T* on_device, cudaStream_t stream) {
    Check(cudaMemcpyAsync(value_, on_device, sizeof(T), cudaMemcpyDeviceToHost, stream),
          "cudaMemcpyAsync");
  }
  const T& Last() const { return *value_; }

 private:
  T* value_ = nullptr;
};

}  // namespace cosplat::cuda
