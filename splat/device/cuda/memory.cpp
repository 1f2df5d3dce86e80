#include "splat/device/cuda/memory.h"

#include <cstdio>
#include <string>

namespace cosplat::cuda {
namespace {

std::string Megabytes(size_t bytes) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.1f MB", double(bytes) * 1e-6);
  return text;
}

}  // namespace

void* AllocateDevice(size_t bytes) {
  void* p = nullptr;
  const cudaError_t error = cudaMalloc(&p, bytes);
  if (error == cudaErrorMemoryAllocation) {
    cudaGetLastError();
    size_t free = 0, total = 0;
    Check(cudaMemGetInfo(&free, &total), "cudaMemGetInfo");
    throw Error("CUDA",
                "the device has no room for " + Megabytes(bytes) + " more: " + Megabytes(free) +
                    " of " + Megabytes(total) + " are free");
  }
  Check(error, "cudaMalloc");
  return p;
}

}  // namespace cosplat::cuda
