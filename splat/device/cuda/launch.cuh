// Launches bodies: small structs of views with a device operator().
#pragma once

#include <cuda_runtime.h>

#include <cstddef>
#include <cstdint>

#include "splat/device/cuda/stream.h"

namespace cosplat::cuda {

constexpr unsigned kWarp = 32;
constexpr unsigned kAllLanes = 0xffffffffu;

#if defined(__CUDACC__)
// The block's shared memory as a T, initially uninitialised.
template <class T>
__device__ T& SharedMemory() {
  __shared__ alignas(16) unsigned char bytes[sizeof(T)];
  return *reinterpret_cast<T*>(bytes);
}
// The same of a size that the launch states.
template <class T>
__device__ T* SharedArray() {
  extern __shared__ __align__(16) unsigned char launched_bytes[];
  return reinterpret_cast<T*>(launched_bytes);
}
#endif

__device__ inline unsigned Lane() { return threadIdx.x % kWarp; }
__device__ inline unsigned WarpInBlock() { return threadIdx.x / kWarp; }

constexpr unsigned kElementThreads = 256;

template <class Body>
__global__ void __launch_bounds__(kElementThreads) ThreadsKernel(size_t n, Body body) {
  const size_t i = size_t(blockIdx.x) * kElementThreads + threadIdx.x;
  if (i < n) body(i);
}

template <class Body>
__global__ void __launch_bounds__(Body::kThreads) BlocksKernel(Body body) {
  body();
}

template <class... Parameters, class... Arguments>
void Launch(size_t blocks,
            unsigned threads,
            size_t shared_bytes,
            Stream& stream,
            void (*kernel)(Parameters...),
            const Arguments&... arguments) {
  if (blocks == 0) return;
  cudaLaunchConfig_t config{};
  config.gridDim = dim3(unsigned(blocks));
  config.blockDim = dim3(threads);
  config.dynamicSmemBytes = shared_bytes;
  config.stream = HandleOf(stream);
  Check(cudaLaunchKernelEx(&config, kernel, arguments...), "cudaLaunchKernelEx");
}

// body(i) for i < n, one thread each. n < 2^39.
template <class Body>
void ForEachThread(size_t n, Stream& stream, const Body& body) {
  const size_t blocks = (n + kElementThreads - 1) / kElementThreads;
  Launch(blocks, kElementThreads, 0, stream, &ThreadsKernel<Body>, n, body);
}

// body() in every thread of blocks of Body::kThreads. shared_bytes: of SharedArray.
template <class Body>
void ForBlocks(size_t blocks, Stream& stream, const Body& body, size_t shared_bytes = 0) {
  Launch(blocks, Body::kThreads, shared_bytes, stream, &BlocksKernel<Body>, body);
}

}  // namespace cosplat::cuda
