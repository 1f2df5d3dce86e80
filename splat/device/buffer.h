// Memory that kernels get: Buffer<T> owns, View<T> borrows.
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

// What is sized for one view gets room for one that is larger by this part.
constexpr size_t kHeadRoom = 8;

// Elements in the host's memory or in a device's: in that of the stream of the last Refill or
// Upload, in the host's at first. 64-byte aligned, so that packs of any instruction set load whole
// cache lines.
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
  // In its own memory: to be read by the host only where that is the host's.
  T* data() { return data_; }
  const T* data() const { return data_; }
  View<T> view() { return {data_, size_}; }
  View<const T> view() const { return {data_, size_}; }

  // In any memory.

  // n elements of any values, for a size that varies from call to call: what was there is lost. A
  // device is waited for where it has to grow.
  void Refill(size_t n, Stream& stream) {
    if (n > capacity_ || memory_ != &stream.memory()) {
      Release();
      memory_ = &stream.memory();
      Reserve(n + n / kHeadRoom);
    }
    size_ = n;
  }
  void FillWithZeros(Stream& stream) {
    if (size_ != 0) stream.FillWithZeros(data_, size_ * sizeof(T));
  }
  // Takes over `n` elements of the host's memory, which must stay until the stream was waited for.
  void Upload(const T* from, size_t n, Stream& stream) {
    Refill(n, stream);
    if (n != 0) stream.Upload(data_, from, n * sizeof(T));
  }
  // To [size()] elements of the host's memory; they are there when the stream was waited for.
  void Download(T* to, Stream& stream) const {
    if (size_ != 0) stream.Download(to, data_, size_ * sizeof(T));
  }

  // In the host's memory alone: as std::vector.

  explicit Buffer(size_t n, const T& value = T()) { resize(n, value); }
  Buffer(std::initializer_list<T> values) { assign(values.begin(), values.end()); }
  Buffer(const std::vector<T>& values)  // NOLINT: both hold the same
      : Buffer(values.begin(), values.end()) {}
  operator std::vector<T>() const { return {begin(), end()}; }  // NOLINT: likewise
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
  bool OnHost() const { return !memory_ || memory_ == &HostStream().memory(); }
  void Release() noexcept {
    if (data_) memory_->Free(data_, capacity_ * sizeof(T));
    data_ = nullptr;
    size_ = capacity_ = 0;
  }
  void Reserve(size_t n) {  // of nothing
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

  Memory* memory_ = nullptr;  // null: the host's
  T* data_ = nullptr;
  size_t size_ = 0, capacity_ = 0;
};

// Pointer and count; no ownership. A View<const T> is made of any buffer or vector; of a temporary
// one, for as long as the call that it is passed to. Indices are checked where asserts are compiled
// in.
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

// What a training run holds, by name: Trainer::Memory adds up what its parts say of themselves.

// What a part grows with; kFixed: with neither.
enum class MemoryOf { kGaussians, kPixels, kFixed };

struct MemoryPart {
  std::string name;
  size_t bytes = 0;  // by capacity: what was allocated, whether in use or not
  MemoryOf of = MemoryOf::kGaussians;
};

// Bytes that buffers or vectors hold.
template <class... Containers>
size_t HeldBy(const Containers&... containers) {
  return (size_t(0) + ... + (containers.capacity() * sizeof(*containers.data())));
}

}  // namespace cosplat
