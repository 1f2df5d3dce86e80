#include <algorithm>
#include <array>
#include <cstring>
#include <new>
#include <utility>

#include "splat/device/buffer.h"
#include "splat/device/sort.h"
#include "splat/device/stream.h"

namespace cosplat {
namespace {

constexpr std::align_val_t kAlignment{64};

class OwnMemory : public Memory {
 public:
  void* Allocate(size_t bytes) override { return ::operator new(bytes, kAlignment); }
  void Free(void* data, size_t) override { ::operator delete(data, kAlignment); }
};

constexpr int kDigitBits = 8;
constexpr size_t kDigits = size_t(1) << kDigitBits;

// Sorts by up to a digit's bits of the keys, from one pair of buffers to the other.
void SortByDigit(KeyedValues& pairs, int shift, int bits) {
  const size_t n = pairs.keys.size();
  const uint32_t mask = (uint32_t(1) << bits) - 1;
  const auto digit = [&](size_t i) { return pairs.keys[i] >> shift & mask; };
  std::array<size_t, kDigits + 1> begin{};
  for (size_t i = 0; i < n; ++i) ++begin[digit(i) + 1];
  for (size_t d = 0; d < kDigits; ++d) begin[d + 1] += begin[d];
  for (size_t i = 0; i < n; ++i) {
    const size_t to = begin[digit(i)]++;
    pairs.keys_swap[to] = pairs.keys[i];
    pairs.values_swap[to] = pairs.values[i];
  }
  pairs.keys.swap(pairs.keys_swap);
  pairs.values.swap(pairs.values_swap);
}

// Host work is complete as soon as it is submitted.
class HostEvent : public StreamEvent {
 public:
  void Record() override {}
  void Wait() const override {}
};

class OwnStream : public Stream {
 public:
  Memory& memory() const override { return Own(); }
  void Upload(void* to, const void* from, size_t bytes) override { Copy(to, from, bytes); }
  void Download(void* to, const void* from, size_t bytes) override { Copy(to, from, bytes); }
  void Send(void* to, const void* from, size_t bytes) override { Copy(to, from, bytes); }
  void FillWithZeros(void* data, size_t bytes) override {
    if (bytes > 0) std::memset(data, 0, bytes);
  }
  void Wait() override {}
  Memory& readback_memory() const override { return Own(); }
  std::unique_ptr<StreamEvent> MakeEvent() override { return std::make_unique<HostEvent>(); }
  std::unique_ptr<Stream> Another() const override { return std::make_unique<OwnStream>(); }
  void Sort(KeyedValues& pairs, int bits) override {
    for (int shift = 0; shift < bits; shift += kDigitBits)
      SortByDigit(pairs, shift, std::min(kDigitBits, bits - shift));
  }
  void ExclusiveSum(Buffer<uint64_t>& numbers) override {
    uint64_t sum = 0;
    for (uint64_t& number : numbers) sum += std::exchange(number, sum);
  }

 private:
  // An empty array may be null, which memcpy must not get.
  static void Copy(void* to, const void* from, size_t bytes) {
    if (bytes > 0) std::memcpy(to, from, bytes);
  }
  // Never destroyed, since buffers of threads may outlive static objects.
  static Memory& Own() {
    static OwnMemory& memory = *new OwnMemory;
    return memory;
  }
};

}  // namespace

Stream& HostStream() {
  static OwnStream& stream = *new OwnStream;
  return stream;
}

}  // namespace cosplat
