// Where work is done and where its memory is: the host's, or a CUDA device's
// (splat/device/cuda/stream.h).
//
// One logic for both: a Buffer (splat/device/buffer.h) lies in a stream's memory, ForEach
// (splat/device/for_each.h) runs a kernel over its elements there, and what the kernels cannot do
// alone (copying, sorting, sums) the stream does. Work is done in the order in which it was given:
// at once on the host, later on a device.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

namespace cosplat {

template <class T>
class Buffer;
struct KeyedValues;  // splat/device/sort.h

class Memory {
 public:
  virtual ~Memory() = default;
  // At least 64-byte aligned. Throws std::bad_alloc, or Error on a device, where there is no room.
  virtual void* Allocate(size_t bytes) = 0;
  virtual void Free(void* data, size_t bytes) = 0;
};

// A moment in a stream.
class Moment {
 public:
  virtual ~Moment() = default;
  virtual void Record() = 0;
  // The host waits until it has come to pass; not at all where it was never recorded.
  virtual void Wait() const = 0;
};

class Stream {
 public:
  virtual ~Stream() = default;

  virtual Memory& memory() const = 0;
  // Whether its memory is the host's, and what it was given is done when the call returns.
  bool on_host() const;

  // From and to the host's memory; `to` has it when the stream has been waited for, and `from` must
  // stay until then.
  virtual void Upload(void* to, const void* from, size_t bytes) = 0;
  virtual void Download(void* to, const void* from, size_t bytes) = 0;
  // As Upload, but `from` is free at once; nobody waits for what the stream is at.
  virtual void Send(void* to, const void* from, size_t bytes) = 0;
  virtual void FillWithZeros(void* data, size_t bytes) = 0;
  virtual void Wait() = 0;

  // Stable, by the lowest `bits` bits of the keys.
  virtual void Sort(KeyedValues& pairs, int bits) = 0;
  // Each number becomes the sum of those before it.
  virtual void ExclusiveSum(Buffer<uint64_t>& numbers) = 0;
  virtual size_t held() const { return 0; }  // bytes of scratch

  // Bytes that its memory has left. The host's is not reckoned with: the most that there are.
  virtual size_t FreeMemory() const { return size_t(-1); }
  // Memory of the host's that Download need not wait for.
  virtual Memory& readback_memory() const = 0;
  virtual std::unique_ptr<Moment> MakeMoment() = 0;
  // Another one of the same device, for work in any order beside this one's.
  virtual std::unique_ptr<Stream> Another() const = 0;
};

// Of what is free: allocators do not get all of it.
constexpr double kUsableMemory = 0.9;

// Has no state: one for all.
Stream& HostStream();

inline bool Stream::on_host() const { return &memory() == &HostStream().memory(); }

// One value that a stream tells the host.
template <class T>
class Readback {
 public:
  explicit Readback(Stream& stream)
      : memory_(stream.readback_memory()), value_(static_cast<T*>(memory_.Allocate(sizeof(T)))) {
    *value_ = T();
  }
  ~Readback() { memory_.Free(value_, sizeof(T)); }
  Readback(const Readback&) = delete;
  Readback& operator=(const Readback&) = delete;
  // Reads what is there after all that the stream was given so far: the host waits.
  const T& Get(const T* from, Stream& stream) {
    Ask(from, stream);
    stream.Wait();
    return *value_;
  }
  // Without waiting: Last has it once the stream was waited for.
  void Ask(const T* from, Stream& stream) { stream.Download(value_, from, sizeof(T)); }
  const T& Last() const { return *value_; }

 private:
  Memory& memory_;
  T* value_;
};

}  // namespace cosplat
