#include "splat/device/cuda/stream.h"

#include <cstdio>
#include <cstring>
#include <string>

#include "splat/device/cuda/device.h"

namespace cosplat::cuda {
namespace {

std::string Megabytes(size_t bytes) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.1f MB", double(bytes) * 1e-6);
  return text;
}

class CudaMemory : public Memory {
 public:
  // Throws Error with the requested and the free memory.
  void* Allocate(size_t bytes) override {
    void* p = nullptr;
    const cudaError_t error = cudaMalloc(&p, bytes);
    if (error == cudaErrorMemoryAllocation) {
      cudaGetLastError();
      size_t free = 0, total = 0;
      Check(cudaMemGetInfo(&free, &total), "cudaMemGetInfo");
      throw Error("CUDA",
                  "out of device memory: " + Megabytes(bytes) + " requested, " + Megabytes(free) +
                      " of " + Megabytes(total) + " free");
    }
    Check(error, "cudaMalloc");
    return p;
  }
  void Free(void* data, size_t) override { cudaFree(data); }
  bool on_host() const override { return false; }
};

class PinnedMemory : public Memory {
 public:
  void* Allocate(size_t bytes) override {
    void* p = nullptr;
    Check(cudaMallocHost(&p, bytes), "cudaMallocHost");
    return p;
  }
  void Free(void* data, size_t) override { cudaFreeHost(data); }
};

class CudaStreamEvent : public StreamEvent {
 public:
  explicit CudaStreamEvent(cudaStream_t stream) : stream_(stream) {}
  void Record() override { event_.Record(stream_); }
  void Wait() const override { event_.Wait(); }

 private:
  cudaStream_t stream_;
  Event event_;
};

// CUDA's version numbers: 1000 major + 10 minor.
std::string VersionText(int version) {
  return std::to_string(version / 1000) + "." + std::to_string(version % 1000 / 10);
}

}  // namespace

std::unique_ptr<StreamEvent> CudaStream::MakeEvent() {
  return std::make_unique<CudaStreamEvent>(stream_);
}

size_t FreeMemory() {
  size_t free = 0, total = 0;
  Check(cudaMemGetInfo(&free, &total), "cudaMemGetInfo");
  return free;
}

Memory& CudaStream::memory() const {
  // Never destroyed, since buffers may outlive static objects.
  static CudaMemory& memory = *new CudaMemory;
  return memory;
}

Memory& CudaStream::readback_memory() const {
  static PinnedMemory& memory = *new PinnedMemory;
  return memory;
}

size_t CudaStream::FreeMemory() const { return cuda::FreeMemory(); }

void CudaStream::Upload(void* to, const void* from, size_t bytes) {
  Check(cudaMemcpyAsync(to, from, bytes, cudaMemcpyHostToDevice, stream_), "cudaMemcpyAsync");
}

void CudaStream::Download(void* to, const void* from, size_t bytes) {
  Check(cudaMemcpyAsync(to, from, bytes, cudaMemcpyDeviceToHost, stream_), "cudaMemcpyAsync");
}

void CudaStream::Send(void* to, const void* from, size_t bytes) {
  if (bytes == 0) return;
  Piece& piece = pieces_[next_];
  next_ = 1 - next_;
  piece.sent.Wait();
  if (bytes > piece.bytes) {
    Check(cudaFreeHost(std::exchange(piece.memory, nullptr)), "cudaFreeHost");
    piece.bytes = 0;
    Check(cudaMallocHost(&piece.memory, bytes), "cudaMallocHost");
    piece.bytes = bytes;
  }
  std::memcpy(piece.memory, from, bytes);
  Upload(to, piece.memory, bytes);
  piece.sent.Record(stream_);
}

void CudaStream::FillWithZeros(void* data, size_t bytes) {
  Check(cudaMemsetAsync(data, 0, bytes, stream_), "cudaMemsetAsync");
}

void CudaStream::Wait() { Check(cudaStreamSynchronize(stream_), "cudaStreamSynchronize"); }

std::optional<DeviceInfo> FindDevice() {
  if (!WhyNoDevice().empty()) return std::nullopt;
  int device = 0;
  cudaDeviceProp p{};
  Check(cudaGetDevice(&device), "cudaGetDevice");
  Check(cudaGetDeviceProperties(&p, device), "cudaGetDeviceProperties");
  return DeviceInfo{p.name, p.major, p.minor, p.multiProcessorCount, p.totalGlobalMem};
}

size_t DeviceCount() {
  int count = 0;
  Check(cudaGetDeviceCount(&count), "cudaGetDeviceCount");
  return size_t(count);
}

void UseDevice(size_t index) { Check(cudaSetDevice(int(index % DeviceCount())), "cudaSetDevice"); }

std::string WhyNoDevice() {
  int count = 0;
  const cudaError_t error = cudaGetDeviceCount(&count);
  if (error == cudaSuccess && count > 0) return "";
  cudaGetLastError();  // the caller may go on without a device
  if (error == cudaErrorInsufficientDriver) {
    int driver = 0, runtime = 0;
    cudaDriverGetVersion(&driver);
    cudaRuntimeGetVersion(&runtime);
    if (driver > 0)
      return "the NVIDIA driver is too old: it supports CUDA " + VersionText(driver) +
             ", this program needs " + VersionText(runtime);
  }
  if (error == cudaSuccess || error == cudaErrorNoDevice || error == cudaErrorInsufficientDriver)
    return "no CUDA device was found";
  return std::string("no CUDA device was found: ") + cudaGetErrorString(error);
}

}  // namespace cosplat::cuda
