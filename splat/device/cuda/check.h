// Every call of the CUDA runtime goes through Check.
#pragma once

#include <cuda_runtime.h>

#include <string>

#include "splat/base/error.h"

namespace cosplat::cuda {

// Throws Error naming the call and the reason.
inline void Check(cudaError_t error, const char* call) {
  if (error == cudaSuccess) return;
  cudaGetLastError();  // so that the next call is not blamed for this one
  throw Error("CUDA", std::string(call) + ": " + cudaGetErrorString(error));
}

}  // namespace cosplat::cuda
