// An execution queue with its memory: the host's, or a CUDA device's (splat/device/cuda/stream.h).
//
// The same code serves both: a Buffer (splat/device/buffer.h) lies in a stream's memory, ForEach
// (splat/device/for_each.h) runs a kernel over its elements there, and the stream itself provides
// what kernels cannot (copying, sorting, sums). Work is executed in submission order: immediately
// on the host, asynchronously on a device.
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
  // At least 64-byte aligned. If memory runs out, throws std::bad_alloc, or Error on a device.
  virtual void* Allocate(size_t bytes) = 0;
  virtual void Free(void* data, size_t bytes) = 0;
  // Whether the host may read and write it.
  virtual bool on_host() const { return true; }
};

// A point in a stream's work, like a CUDA event.
class StreamEvent {
 public:
  virtual ~StreamEvent() = default;
  virtual void Record() = 0;
  // Blocks the host until the recorded point is reached; returns at once if none was recorded.
  virtual void Wait() const = 0;
};

class Stream {
 public:
  virtual ~Stream() = default;

  virtual Memory& memory() const = 0;
  // Whether its memory is the host's and all work is complete when a call returns.
  bool on_host() const;

  // Copy from and to host memory. `to` is valid once the stream has been waited for, and `from`
  // must stay valid until then.
  virtual void Upload(void* to, const void* from, size_t bytes) = 0;
  virtual void Download(void* to, const void* from, size_t bytes) = 0;
  // Like Upload, but `from` may be reused at once, without waiting for the stream's pending work.
  virtual void Send(void* to, const void* from, size_t bytes) = 0;
  virtual void FillWithZeros(void* data, size_t bytes) = 0;
  virtual void Wait() = 0;

  // Stable sort by the lowest `bits` bits of the keys.
  virtual void Sort(KeyedValues& pairs, int bits) = 0;
  // Replaces each number by the sum of those before it.
  virtual void ExclusiveSum(Buffer<uint64_t>& numbers) = 0;
  virtual size_t allocated_bytes() const { return 0; }  // bytes of scratch

  // Free bytes of its memory. Not determined for the host, for which the maximum is returned.
  virtual size_t FreeMemory() const { return size_t(-1); }
  // Host memory to which Download is asynchronous.
  virtual Memory& readback_memory() const = 0;
  virtual std::unique_ptr<StreamEvent> MakeEvent() = 0;
  // Another stream of the same device, for concurrent work.
  virtual std::unique_ptr<Stream> Another() const = 0;
};

// Usable fraction of the free memory: allocators do not get all of it.
constexpr double kUsableMemory = 0.9;

// Stateless, and shared by all threads.
Stream& HostStream();

inline bool Stream::on_host() const { return &memory() == &HostStream().memory(); }

// Reads single values back from a stream's memory.
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
  // Returns the value after all work submitted so far; blocks the host.
  const T& Get(const T* from, Stream& stream) {
    Ask(from, stream);
    stream.Wait();
    return *value_;
  }
  // Without waiting: Last returns the value once the stream has been waited for.
  void Ask(const T* from, Stream& stream) { stream.Download(value_, from, sizeof(T)); }
  const T& Last() const { return *value_; }

 private:
  Memory& memory_;
  T* value_;
};

}  // namespace cosplat
