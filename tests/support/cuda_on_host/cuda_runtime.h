// What splat/*/cuda uses of CUDA, for a compiler that knows nothing of it: the same sources then
// run on the host (execution.h, runtime.h). Found in place of the toolkit's header by the targets
// that tests/cuda builds.
#pragma once

#include <atomic>
#include <bit>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <source_location>
#include <tuple>
#include <type_traits>

#include "tests/support/cuda_on_host/execution.h"
#include "tests/support/cuda_on_host/runtime.h"

#define __global__
#define __device__
#define __host__
#define __forceinline__ inline
#define __launch_bounds__(...)

using dim3 = cuda_on_host::Dim;

struct alignas(16) float4 {
  float x, y, z, w;
};
inline float4 make_float4(float x, float y, float z, float w) { return {x, y, z, w}; }

// --- The device's side.

namespace cuda_on_host {
using Place = std::source_location;

template <class T>
uint64_t ToBits(T value) {
  static_assert(sizeof(T) <= sizeof(uint64_t) && std::is_trivially_copyable_v<T>);
  uint64_t bits = 0;
  std::memcpy(&bits, &value, sizeof(T));
  return bits;
}
template <class T>
T FromBits(uint64_t bits) {
  T value;
  std::memcpy(&value, &bits, sizeof(T));
  return value;
}
template <class T>
T ValueOfLane(unsigned mask, T value, unsigned lane, const Place& where) {
  return FromBits<T>(MeetWarp(mask, ToBits(value), MemoryOrder::kNone, where)[lane]);
}
}  // namespace cuda_on_host

inline void __syncthreads(cuda_on_host::Place where = cuda_on_host::Place::current()) {
  cuda_on_host::MeetBlock(0, where);
}
inline int __syncthreads_count(int value,
                               cuda_on_host::Place where = cuda_on_host::Place::current()) {
  return cuda_on_host::MeetBlock(value, where);
}
inline void __syncwarp(unsigned mask = ~0u,
                       cuda_on_host::Place where = cuda_on_host::Place::current()) {
  cuda_on_host::MeetWarp(mask, 0, cuda_on_host::MemoryOrder::kOrdered, where);
}
template <class T>
T __shfl_sync(unsigned mask,
              T value,
              int lane,
              cuda_on_host::Place where = cuda_on_host::Place::current()) {
  return cuda_on_host::ValueOfLane(mask, value, unsigned(lane) % 32, where);
}
template <class T>
T __shfl_up_sync(unsigned mask,
                 T value,
                 unsigned by,
                 cuda_on_host::Place where = cuda_on_host::Place::current()) {
  const unsigned lane = cuda_on_host::Lane();
  return cuda_on_host::ValueOfLane(mask, value, lane >= by ? lane - by : lane, where);
}
template <class T>
T __shfl_down_sync(unsigned mask,
                   T value,
                   unsigned by,
                   cuda_on_host::Place where = cuda_on_host::Place::current()) {
  const unsigned lane = cuda_on_host::Lane();
  return cuda_on_host::ValueOfLane(mask, value, lane + by < 32 ? lane + by : lane, where);
}
inline unsigned __ballot_sync(unsigned mask,
                              int predicate,
                              cuda_on_host::Place where = cuda_on_host::Place::current()) {
  const uint64_t* votes =
      cuda_on_host::MeetWarp(mask, predicate != 0, cuda_on_host::MemoryOrder::kNone, where);
  unsigned bits = 0;
  for (unsigned l = 0; l < 32; ++l) bits |= unsigned(votes[l]) << l;
  return bits;
}
inline int __any_sync(unsigned mask,
                      int predicate,
                      cuda_on_host::Place where = cuda_on_host::Place::current()) {
  return __ballot_sync(mask, predicate, where) != 0;
}
inline int __popc(unsigned x) { return std::popcount(x); }
inline int __ffs(unsigned x) { return x == 0 ? 0 : std::countr_zero(x) + 1; }
inline float __expf(float x) { return std::exp(x); }
template <class T>
T atomicAdd(T* p, std::type_identity_t<T> value) {
  return std::atomic_ref<T>(*p).fetch_add(value, std::memory_order_relaxed);
}

namespace cosplat::cuda {
template <class T>
T& SharedMemory() {
  static const char key = 0;
  return *static_cast<T*>(cuda_on_host::SharedMemoryOf(&key, sizeof(T)));
}
template <class T>
T* SharedArray() {
  static const char key = 0;
  return static_cast<T*>(cuda_on_host::SharedMemoryOf(&key, cuda_on_host::launched_shared_bytes));
}
}  // namespace cosplat::cuda

// --- The host's side.

enum cudaError_t {
  cudaSuccess = 0,
  cudaErrorInvalidValue = 1,
  cudaErrorMemoryAllocation = 2,
  cudaErrorInsufficientDriver = 35,
  cudaErrorNoDevice = 100
};
inline const char* cudaGetErrorString(cudaError_t error) {
  return error == cudaErrorMemoryAllocation ? "out of memory" : "invalid argument";
}
inline cudaError_t cudaGetLastError() { return cudaSuccess; }

inline cudaError_t cudaGetDevice(int* device) {
  *device = 0;
  return cudaSuccess;
}
struct cudaDeviceProp {
  char name[256] = "the host, pretending";
  size_t totalGlobalMem = size_t(1) << 40;
  int major = 8, minor = 0, multiProcessorCount = 1;
};
inline cudaError_t cudaGetDeviceCount(int* count) {
  const auto error = cudaError_t(cuda_on_host::DriverProblem());
  *count = error == cudaSuccess ? 1 : 0;
  return error;
}
inline cudaError_t cudaSetDevice(int device) {
  return device == 0 ? cudaSuccess : cudaErrorInvalidValue;
}
inline cudaError_t cudaDriverGetVersion(int* version) {
  *version = cuda_on_host::DriverVersion();
  return cudaSuccess;
}
inline cudaError_t cudaRuntimeGetVersion(int* version) {
  *version = 13000;
  return cudaSuccess;
}
inline cudaError_t cudaGetDeviceProperties(cudaDeviceProp* p, int) {
  *p = {};
  return cudaSuccess;
}
inline cudaError_t cudaMemGetInfo(size_t* free, size_t* total) {
  *free = cuda_on_host::FreeMemory();
  *total = size_t(1) << 40;
  return cudaSuccess;
}

inline cudaError_t cudaMalloc(void** p, size_t bytes) {
  *p = cuda_on_host::AllocateOnDevice(bytes);
  return *p ? cudaSuccess : cudaErrorMemoryAllocation;
}
inline cudaError_t cudaFree(void* p) {
  return !p || cuda_on_host::FreeOnDevice(p) ? cudaSuccess : cudaErrorInvalidValue;
}
inline cudaError_t cudaMallocHost(void** p, size_t bytes) {
  *p = cuda_on_host::AllocatePinned(bytes);
  return cudaSuccess;
}
inline cudaError_t cudaFreeHost(void* p) {
  return !p || cuda_on_host::FreePinned(p) ? cudaSuccess : cudaErrorInvalidValue;
}

using cudaStream_t = struct CudaOnHostStream*;
using cudaEvent_t = struct CudaOnHostEvent*;
struct CudaOnHostEvent {
  std::chrono::steady_clock::time_point time;
  uint64_t moment = 0;  // of the stream; 0: not recorded
  bool timed = true;
};
constexpr unsigned cudaStreamNonBlocking = 1;
inline cudaError_t cudaStreamCreateWithFlags(cudaStream_t* stream, unsigned) {
  *stream = nullptr;
  return cudaSuccess;
}
inline cudaError_t cudaStreamDestroy(cudaStream_t) { return cudaSuccess; }
inline cudaError_t cudaStreamSynchronize(cudaStream_t) {
  cuda_on_host::Finish();
  return cudaSuccess;
}
constexpr unsigned cudaEventDefault = 0, cudaEventDisableTiming = 2;
inline cudaError_t cudaEventCreateWithFlags(cudaEvent_t* event, unsigned flags) {
  *event = new CudaOnHostEvent;
  (*event)->timed = (flags & cudaEventDisableTiming) == 0;
  return cudaSuccess;
}
inline cudaError_t cudaEventDestroy(cudaEvent_t event) {
  cuda_on_host::Finish();
  delete event;
  return cudaSuccess;
}
inline cudaError_t cudaEventRecord(cudaEvent_t event, cudaStream_t) {
  cuda_on_host::Enqueue([=] { event->time = std::chrono::steady_clock::now(); });
  event->moment = cuda_on_host::Enqueued();
  return cudaSuccess;
}
inline cudaError_t cudaEventSynchronize(cudaEvent_t event) {
  cuda_on_host::FinishUntil(event->moment);
  return cudaSuccess;
}
inline cudaError_t cudaEventElapsedTime(float* ms, cudaEvent_t from, cudaEvent_t to) {
  if (!from->timed || !to->timed) return cudaErrorInvalidValue;
  *ms = std::chrono::duration<float, std::milli>(to->time - from->time).count();
  return cudaSuccess;
}

enum cudaMemcpyKind { cudaMemcpyHostToDevice, cudaMemcpyDeviceToHost, cudaMemcpyDeviceToDevice };
inline cudaError_t cudaMemcpyAsync(
    void* to, const void* from, size_t bytes, cudaMemcpyKind kind, cudaStream_t) {
  cuda_on_host::Copy(
      to, from, bytes, kind == cudaMemcpyDeviceToHost, kind == cudaMemcpyHostToDevice);
  return cudaSuccess;
}
inline cudaError_t cudaMemsetAsync(void* p, int value, size_t bytes, cudaStream_t) {
  cuda_on_host::Enqueue([=] { std::memset(p, value, bytes); });
  return cudaSuccess;
}

struct cudaLaunchConfig_t {
  dim3 gridDim, blockDim;
  size_t dynamicSmemBytes = 0;
  cudaStream_t stream = nullptr;
};
template <class... Parameters, class... Arguments>
cudaError_t cudaLaunchKernelEx(const cudaLaunchConfig_t* config,
                               void (*kernel)(Parameters...),
                               Arguments&&... arguments) {
  const std::tuple<Parameters...> kept(arguments...);
  cuda_on_host::Enqueue([=,
                         grid = config->gridDim,
                         block = config->blockDim,
                         shared_bytes = config->dynamicSmemBytes] {
    cuda_on_host::launched_shared_bytes = shared_bytes;
    cuda_on_host::RunGrid(grid, block, [&] { std::apply(kernel, kept); });
  });
  return cudaSuccess;
}
