#include <cuda_gl_interop.h>

#include <algorithm>

#include "splat/device/cuda/stream.h"
#include "splat/render/device_texture.h"

namespace cosplat::cuda {
namespace {

constexpr unsigned kMaxDevices = 32;  // maximum per OpenGL context

// With Mesa's renderers, or with another GPU's driver, cudaGLGetDevices lists no device or fails.
void CheckContext() {
  int own = 0;
  Check(cudaGetDevice(&own), "cudaGetDevice");
  unsigned count = 0;
  int devices[kMaxDevices];
  const cudaError_t asked = cudaGLGetDevices(&count, devices, kMaxDevices, cudaGLDeviceListAll);
  cudaGetLastError();  // clears the error, so that the next call does not report it
  if (asked != cudaSuccess) count = 0;
  if (std::find(devices, devices + count, own) != devices + count) return;
  const std::string reason =
      asked == cudaSuccess ? "" : std::string(" (") + cudaGetErrorString(asked) + ")";
  throw Error("OpenGL", "the OpenGL context runs on a different GPU than CUDA" + reason);
}

class GlTexture : public DeviceTexture {
 public:
  explicit GlTexture(unsigned texture) {
    CheckContext();
    Check(cudaGraphicsGLRegisterImage(
              &resource_, texture, GL_TEXTURE_2D, cudaGraphicsRegisterFlagsWriteDiscard),
          "cudaGraphicsGLRegisterImage");
  }
  ~GlTexture() override { cudaGraphicsUnregisterResource(resource_); }
  GlTexture(const GlTexture&) = delete;
  GlTexture& operator=(const GlTexture&) = delete;

  // The host waits, so that the image may be overwritten and errors are reported here.
  void Fill(const DeviceImage& image) override {
    Check(cudaGraphicsMapResources(1, &resource_, stream_.get()), "cudaGraphicsMapResources");
    const cudaError_t copied = Copy(image);
    Check(cudaGraphicsUnmapResources(1, &resource_, stream_.get()), "cudaGraphicsUnmapResources");
    Check(copied, "copying to the texture");
    stream_.Wait();
  }

 private:
  cudaError_t Copy(const DeviceImage& image) {
    cudaArray_t array = nullptr;
    const cudaError_t got = cudaGraphicsSubResourceGetMappedArray(&array, resource_, 0, 0);
    if (got != cudaSuccess) return got;
    const size_t row = sizeof(PixelBytes) * size_t(image.width());
    return cudaMemcpy2DToArrayAsync(array,
                                    0,
                                    0,
                                    image.data(),
                                    row,
                                    row,
                                    size_t(image.height()),
                                    cudaMemcpyDeviceToDevice,
                                    stream_.get());
  }

  CudaStream stream_;
  cudaGraphicsResource_t resource_ = nullptr;
};

}  // namespace

std::unique_ptr<DeviceTexture> MakeGlTexture(unsigned texture) {
  return std::make_unique<GlTexture>(texture);
}

}  // namespace cosplat::cuda
