// RAII wrappers of CUDA streams and events.
#pragma once

#include <cuda_runtime.h>

#include <array>
#include <memory>
#include <string>

#include "splat/base/error.h"
#include "splat/device/buffer.h"

namespace cosplat::cuda {

// All calls of the CUDA runtime go through this. Throws Error naming the call and the reason.
inline void Check(cudaError_t error, const char* call) {
  if (error == cudaSuccess) return;
  cudaGetLastError();  // clears it, so that the next call does not report it
  throw Error("CUDA", std::string(call) + ": " + cudaGetErrorString(error));
}

// A point in a stream's work. It has no time, which makes recording it cheaper.
class Event {
 public:
  Event() : Event(cudaEventDisableTiming) {}
  ~Event() { cudaEventDestroy(event_); }
  Event(const Event&) = delete;
  Event& operator=(const Event&) = delete;
  void Record(cudaStream_t stream) { Check(cudaEventRecord(event_, stream), "cudaEventRecord"); }
  void Record(const Stream& stream);
  // Blocks the host until the recorded point is reached; returns at once if none was recorded.
  void Wait() const { Check(cudaEventSynchronize(event_), "cudaEventSynchronize"); }

 protected:
  explicit Event(unsigned flags) {
    Check(cudaEventCreateWithFlags(&event_, flags), "cudaEventCreateWithFlags");
  }
  cudaEvent_t event_ = nullptr;
};

// The same with the time at which it was reached.
class TimedEvent : public Event {
 public:
  TimedEvent() : Event(cudaEventDefault) {}
  // Time since an earlier recorded event, ms. Waits for this one.
  float MillisecondsSince(const TimedEvent& from) const {
    Wait();
    float ms = 0;
    Check(cudaEventElapsedTime(&ms, from.event_, event_), "cudaEventElapsedTime");
    return ms;
  }
};

// Executes work in submission order. Not the default stream, which waits for all others.
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
  // Copies through one of two pinned buffers in turn, since the other may still be in transfer: the
  // driver may wait for the stream before it reads memory that is not pinned.
  void Send(void* to, const void* from, size_t bytes) override;
  void FillWithZeros(void* data, size_t bytes) override;
  // Blocks the host until all work is done. Errors in kernels are detected here.
  void Wait() override;
  // These use CUB.
  void Sort(KeyedValues& pairs, int bits) override;
  void ExclusiveSum(Buffer<uint64_t>& numbers) override;
  size_t allocated_bytes() const override { return scratch_.capacity(); }
  size_t FreeMemory() const override;
  Memory& readback_memory() const override;  // pinned
  std::unique_ptr<StreamEvent> MakeEvent() override;
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
  Buffer<unsigned char> scratch_;  // for sorts and sums
  std::array<Piece, 2> pieces_;    // for Send
  size_t next_ = 0;
};

// Free device memory in bytes, as reported by the driver.
size_t FreeMemory();

// The CUDA handle of a stream, which must be a CudaStream.
inline cudaStream_t HandleOf(const Stream& stream) {
  return static_cast<const CudaStream&>(stream).get();
}

inline void Event::Record(const Stream& stream) { Record(HandleOf(stream)); }

}  // namespace cosplat::cuda
