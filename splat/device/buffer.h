// Memory passed to kernels: Buffer<T> owns it, View<T> borrows it.
#pragma once

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <cstring>
#include <initializer_list>
#include <iterator>
#include <memory>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "splat/device/stream.h"
#include "splat/math/namespace.h"

namespace cosplat {

template <class T>
struct View;

// Buffers sized for one view get 1/kHeadRoom of extra capacity, for views that need more.
constexpr size_t kHeadRoom = 8;

// An array in host or device memory: that of the stream last passed to Refill or Upload, initially
// the host's. What is said of host memory holds after RefillForReadback, too. 64-byte aligned, so
// that packs of any instruction set load whole cache lines.
template <class T>
class Buffer {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  using value_type = T;
  using iterator = T*;
  using const_iterator = const T*;

  Buffer() = default;
  ~Buffer() { Release(); }
  Buffer(Buffer&& other) noexcept { swap(other); }
  Buffer& operator=(Buffer&& other) noexcept {
    swap(other);
    return *this;
  }
  void swap(Buffer& other) noexcept {
    std::swap(memory_, other.memory_);
    std::swap(data_, other.data_);
    std::swap(size_, other.size_);
    std::swap(capacity_, other.capacity_);
  }

  size_t size() const { return size_; }
  size_t capacity() const { return capacity_; }
  bool empty() const { return size_ == 0; }
  // May be a device pointer, which the host must not dereference.
  T* data() { return data_; }
  const T* data() const { return data_; }
  View<T> view() { return {data_, size_}; }
  View<const T> view() const { return {data_, size_}; }

  // For any memory.

  // Resizes to n elements with unspecified values, for sizes that vary between calls; the previous
  // contents are lost. Growing waits for a device.
  void Refill(size_t n, Stream& stream) { RefillIn(stream.memory(), n); }
  // The same in host memory that the stream downloads to without waiting, which is slow to
  // allocate.
  void RefillForReadback(size_t n, Stream& stream) { RefillIn(stream.readback_memory(), n); }
  void FillWithZeros(Stream& stream) {
    if (size_ != 0) stream.FillWithZeros(data_, size_ * sizeof(T));
  }
  // Copies `n` elements from host memory, which must stay valid until the stream has completed.
  void Upload(const T* from, size_t n, Stream& stream) {
    Refill(n, stream);
    if (n != 0) stream.Upload(data_, from, n * sizeof(T));
  }
  void Upload(View<const T> from, Stream& stream) { Upload(from.data, from.count, stream); }
  // Copies to [size()] elements of host memory, which are valid once the stream has completed.
  void Download(T* to, Stream& stream) const {
    if (size_ != 0) stream.Download(to, data_, size_ * sizeof(T));
  }
  // The same to a container, which is resized.
  template <class Container>
  requires requires(Container& to) { to.resize(0); }
  void Download(Container& to, Stream& stream) const {
    to.resize(size_);
    Download(to.data(), stream);
  }
  // A copy in host memory; the host waits for it.
  std::vector<T> Downloaded(Stream& stream) const {
    std::vector<T> copy;
    Download(copy, stream);
    stream.Wait();
    return copy;
  }

  // For host memory only, with the interface of std::vector.

  explicit Buffer(size_t n, const T& value = T()) { resize(n, value); }
  Buffer(std::initializer_list<T> values) { assign(values.begin(), values.end()); }
  explicit Buffer(const std::vector<T>& values) : Buffer(values.begin(), values.end()) {}
  template <std::forward_iterator It>
  Buffer(It first, It last) {
    assign(first, last);
  }
  Buffer(const Buffer& other) { assign(other.begin(), other.end()); }
  Buffer& operator=(const Buffer& other) {
    if (this != &other) assign(other.begin(), other.end());
    return *this;
  }
  void resize(size_t n, const T& value = T()) {
    assert(OnHost());
    if (n > capacity_) Grow(n);
    if (n > size_) std::uninitialized_fill(data_ + size_, data_ + n, T(value));
    size_ = n;
  }
  void reserve(size_t n) {
    if (n > capacity_) Move(n);
  }
  void clear() { size_ = 0; }
  template <std::forward_iterator It>
  void assign(It first, It last) {
    Replace(size_t(std::distance(first, last)));
    std::copy(first, last, data_);
  }
  void assign(size_t n, const T& value) {
    Replace(n);
    std::fill_n(data_, n, value);
  }
  void push_back(const T& value) { resize(size_ + 1, value); }
  void pop_back() { --size_; }
  template <std::forward_iterator It>
  void append(It first, It last) {
    const size_t before = size_;
    resize(before + size_t(std::distance(first, last)));
    std::copy(first, last, data_ + before);
  }
  void Refill(size_t n) { Refill(n, HostStream()); }
  T& operator[](size_t i) {
    assert(i < size_ && OnHost());
    return data_[i];
  }
  const T& operator[](size_t i) const {
    assert(i < size_ && OnHost());
    return data_[i];
  }
  T* begin() { return data_; }
  T* end() { return data_ + size_; }
  const T* begin() const { return data_; }
  const T* end() const { return data_ + size_; }
  T& front() { return data_[0]; }
  const T& front() const { return data_[0]; }
  T& back() { return data_[size_ - 1]; }
  const T& back() const { return data_[size_ - 1]; }
  friend bool operator==(const Buffer& a, const Buffer& b) {
    return std::equal(a.begin(), a.end(), b.begin(), b.end());
  }

 private:
  bool OnHost() const { return !memory_ || memory_->on_host(); }
  void RefillIn(Memory& memory, size_t n) {
    if (n > capacity_ || memory_ != &memory) {
      Release();
      memory_ = &memory;
      Reserve(n + n / kHeadRoom);
    }
    size_ = n;
  }
  void Release() noexcept {
    if (data_) memory_->Free(data_, capacity_ * sizeof(T));
    data_ = nullptr;
    size_ = capacity_ = 0;
  }
  void Reserve(size_t n) {  // for an empty buffer
    if (n == 0) return;
    if (!memory_) memory_ = &HostStream().memory();
    data_ = static_cast<T*>(memory_->Allocate(n * sizeof(T)));
    capacity_ = n;
  }
  void Replace(size_t n) {
    if (!OnHost() || n > capacity_) {
      Release();
      memory_ = nullptr;
      Reserve(n);
    }
    size_ = n;
  }
  void Grow(size_t n) { Move(std::max(n, 2 * size_)); }
  void Move(size_t n) {
    if (!memory_) memory_ = &HostStream().memory();
    T* const data = static_cast<T*>(memory_->Allocate(n * sizeof(T)));
    if (data_) {
      std::memcpy(static_cast<void*>(data), data_, size_ * sizeof(T));
      memory_->Free(data_, capacity_ * sizeof(T));
    }
    data_ = data;
    capacity_ = n;
  }

  Memory* memory_ = nullptr;  // null: host memory
  T* data_ = nullptr;
  size_t size_ = 0, capacity_ = 0;
};

// Pointer and count, without ownership. A View<const T> converts from any buffer or vector,
// including a temporary, for the duration of the call it is passed to. Indices are checked where
// asserts are enabled.
template <class T>
struct View {
  T* data = nullptr;
  size_t count = 0;

  View() = default;
  COSPLAT_HD View(T* data, size_t count) : data(data), count(count) {}
  template <class U>
  requires std::is_same_v<const U, T> COSPLAT_HD
  View(const View<U>& other)  // NOLINT: borrowing is implicit
      : data(other.data), count(other.count) {}
  template <class Container>
  requires requires(Container&& c) { c.data(); }
  View(Container&& c) : data(c.data()), count(c.size()) {}  // NOLINT: borrowing is implicit
  COSPLAT_HD T& operator[](size_t i) const {
    assert(i < count);
    return data[i];
  }
  COSPLAT_HD T* begin() const { return data; }
  COSPLAT_HD T* end() const { return data + count; }
  COSPLAT_HD size_t size() const { return count; }
  COSPLAT_HD bool empty() const { return count == 0; }
};

// The memory of a training run, by name: Trainer::Memory collects what each of its parts reports.

// What a part grows with; kFixed: neither.
enum class MemoryOf { kGaussians, kPixels, kFixed };

struct MemoryPart {
  std::string name;
  size_t bytes = 0;  // by capacity: what was allocated, whether in use or not
  MemoryOf of = MemoryOf::kGaussians;
};

// Sum of the parts that grow with the same, bytes.
inline size_t SumOf(const std::vector<MemoryPart>& parts, MemoryOf of) {
  size_t bytes = 0;
  for (const MemoryPart& part : parts) bytes += part.of == of ? part.bytes : 0;
  return bytes;
}

// Bytes allocated by buffers or vectors.
template <class... Containers>
size_t AllocatedBytes(const Containers&... containers) {
  return (size_t(0) + ... + (containers.capacity() * sizeof(*containers.data())));
}

}  // namespace cosplat
