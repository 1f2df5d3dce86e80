// Streams and events of a CUDA device, which are given back by themselves.
#pragma once

#include <cuda_runtime.h>

#include <array>
#include <memory>
#include <string>

#include "splat/base/error.h"
#include "splat/device/buffer.h"

namespace cosplat::cuda {

// Every call of the CUDA runtime goes through this. Throws Error naming the call and the reason.
inline void Check(cudaError_t error, const char* call) {
  if (error == cudaSuccess) return;
  cudaGetLastError();  // so that the next call is not blamed for this one
  throw Error("CUDA", std::string(call) + ": " + cudaGetErrorString(error));
}

// A moment in a stream.
class Event {
 public:
  Event() { Check(cudaEventCreate(&event_), "cudaEventCreate"); }
  ~Event() { cudaEventDestroy(event_); }
  Event(const Event&) = delete;
  Event& operator=(const Event&) = delete;
  void Record(cudaStream_t stream) { Check(cudaEventRecord(event_, stream), "cudaEventRecord"); }
  void Record(const Stream& stream);
  // The host waits until it has come to pass; not at all where it was never recorded.
  void Wait() const { Check(cudaEventSynchronize(event_), "cudaEventSynchronize"); }
  // From another that was recorded before, ms. Waits for this one.
  float MillisecondsSince(const Event& from) const {
    Wait();
    float ms = 0;
    Check(cudaEventElapsedTime(&ms, from.event_, event_), "cudaEventElapsedTime");
    return ms;
  }

 private:
  cudaEvent_t event_ = nullptr;
};

// Work in the order in which it was given. Not the default stream, which waits for all others.
class CudaStream : public Stream {
 public:
  CudaStream() {
    Check(cudaStreamCreateWithFlags(&stream_, cudaStreamNonBlocking), "cudaStreamCreate");
  }
  ~CudaStream() override { cudaStreamDestroy(stream_); }
  CudaStream(const CudaStream&) = delete;
  CudaStream& operator=(const CudaStream&) = delete;

  Memory& memory() const override;
  void Upload(void* to, const void* from, size_t bytes) override;
  void Download(void* to, const void* from, size_t bytes) override;
  // By way of pinned memory, in two pieces in turn, since one may still be on its way: the driver
  // may wait for the stream before it reads memory that is not pinned.
  void Send(void* to, const void* from, size_t bytes) override;
  void FillWithZeros(void* data, size_t bytes) override;
  // The host waits for all of it. What a kernel did wrong is found here.
  void Wait() override;
  // By CUB.
  void Sort(KeyedValues& pairs, int bits) override;
  void ExclusiveSum(Buffer<uint64_t>& numbers) override;
  size_t held() const override { return scratch_.capacity(); }
  size_t FreeMemory() const override;
  Memory& readback_memory() const override;  // pinned
  std::unique_ptr<Moment> MakeMoment() override;
  std::unique_ptr<Stream> Another() const override { return std::make_unique<CudaStream>(); }
  cudaStream_t get() const { return stream_; }

 private:
  struct Piece {
    Piece() = default;
    ~Piece() { cudaFreeHost(memory); }
    Piece(const Piece&) = delete;
    Piece& operator=(const Piece&) = delete;

    void* memory = nullptr;
    size_t bytes = 0;
    Event sent;
  };

  cudaStream_t stream_ = nullptr;
  Buffer<unsigned char> scratch_;  // of sorts and sums
  std::array<Piece, 2> pieces_;    // of what is sent
  size_t next_ = 0;
};

// Bytes of the device that are free, as the driver says.
size_t FreeMemory();

// CUDA's name of a stream, which must be a device's.
inline cudaStream_t HandleOf(const Stream& stream) {
  return static_cast<const CudaStream&>(stream).get();
}

inline void Event::Record(const Stream& stream) { Record(HandleOf(stream)); }

}  // namespace cosplat::cuda
