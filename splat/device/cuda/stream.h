// Streams and events that are given back by themselves.
#pragma once

#include "splat/device/cuda/check.h"

namespace cosplat::cuda {

// Work in the order in which it was given. Not the default stream, which waits for all others.
class Stream {
 public:
  Stream() {
    Check(cudaStreamCreateWithFlags(&stream_, cudaStreamNonBlocking), "cudaStreamCreate");
  }
  ~Stream() { cudaStreamDestroy(stream_); }
  Stream(const Stream&) = delete;
  Stream& operator=(const Stream&) = delete;
  cudaStream_t get() const { return stream_; }
  // The host waits for all of it. What a kernel did wrong is found here.
  void Wait() const { Check(cudaStreamSynchronize(stream_), "cudaStreamSynchronize"); }

 private:
  cudaStream_t stream_ = nullptr;
};

// A moment in a stream.
class Event {
 public:
  Event() { Check(cudaEventCreate(&event_), "cudaEventCreate"); }
  ~Event() { cudaEventDestroy(event_); }
  Event(const Event&) = delete;
  Event& operator=(const Event&) = delete;
  void Record(cudaStream_t stream) { Check(cudaEventRecord(event_, stream), "cudaEventRecord"); }
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

}  // namespace cosplat::cuda
