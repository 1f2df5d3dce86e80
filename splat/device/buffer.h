// Memory that kernels get: Buffer<T> owns, View<T> borrows.
#pragma once

#include <cstddef>
#include <cstdlib>
#include <new>
#include <vector>

namespace cosplat {

// 64-byte aligned, so that packs of any instruction set load whole cache lines.
template <class T>
struct AlignedAllocator {
  using value_type = T;
  static constexpr std::align_val_t kAlignment{64};
  AlignedAllocator() = default;
  template <class U>
  AlignedAllocator(const AlignedAllocator<U>&) {}  // NOLINT: required conversion
  T* allocate(size_t n) { return static_cast<T*>(::operator new(n * sizeof(T), kAlignment)); }
  void deallocate(T* p, size_t) { ::operator delete(p, kAlignment); }
  bool operator==(const AlignedAllocator&) const { return true; }
};

template <class T>
using Buffer = std::vector<T, AlignedAllocator<T>>;

// What is sized for one view gets room for one that is larger by this part.
constexpr size_t kHeadRoom = 8;

// n elements of any values, for a buffer whose size varies from call to call: resizing alone would
// double what it holds, and copy what is about to be overwritten.
template <class T>
void Refill(Buffer<T>& buffer, size_t n) {
  if (n > buffer.capacity()) {
    Buffer<T>().swap(buffer);
    buffer.reserve(n + n / kHeadRoom);
  }
  buffer.resize(n);
}

// Pointer and count; no ownership. A View<const T> is made of any buffer or vector; of a temporary
// one, for as long as the call that it is passed to.
template <class T>
struct View {
  T* data = nullptr;
  size_t count = 0;

  View() = default;
  View(T* data, size_t count) : data(data), count(count) {}
  template <class Container>
  requires requires(Container&& c) { c.data(); }
  View(Container&& c) : data(c.data()), count(c.size()) {}  // NOLINT: borrowing is implicit
  T& operator[](size_t i) const { return data[i]; }
  T* begin() const { return data; }
  T* end() const { return data + count; }
  size_t size() const { return count; }
  bool empty() const { return count == 0; }
};

}  // namespace cosplat
