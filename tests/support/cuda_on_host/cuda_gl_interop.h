// What splat/*/cuda uses of CUDA's interoperability with OpenGL, on the host's emulation of a
// device: textures of whatever OpenGL there is (Mesa's). Found in place of the toolkit's header.
//
// What a mapped texture gets is copied by OpenGL when it is unmapped. Calls without a context, of a
// texture that is gone or has other storage than was registered, or in the wrong order, are Faults.
#pragma once

#include <GL/gl.h>

#include "tests/support/cuda_on_host/cuda_runtime.h"

namespace cuda_on_host {

// What the next windows are: of the device, of another, with textures that cannot be shared.
enum class GlKind { kOfDevice, kOfAnother, kNotShared, kBreaksOff };
void SetGlKind(GlKind kind);

struct GlCounts {
  int registered = 0;  // textures, now
  int registrations = 0, copies = 0;
  int faults = 0;  // in destructors, which must not throw
};
GlCounts CountsOfGl();
void ResetGl();

}  // namespace cuda_on_host

using cudaArray_t = struct CudaOnHostArray*;
using cudaGraphicsResource_t = struct CudaOnHostTexture*;
enum cudaGLDeviceList { cudaGLDeviceListAll = 1 };
constexpr unsigned cudaGraphicsRegisterFlagsWriteDiscard = 2;

cudaError_t cudaGLGetDevices(unsigned* count, int* devices, unsigned max, cudaGLDeviceList list);
cudaError_t cudaGraphicsGLRegisterImage(cudaGraphicsResource_t* resource,
                                        GLuint texture,
                                        GLenum target,
                                        unsigned flags);
cudaError_t cudaGraphicsUnregisterResource(cudaGraphicsResource_t resource);
cudaError_t cudaGraphicsMapResources(int count,
                                     cudaGraphicsResource_t* resources,
                                     cudaStream_t stream);
cudaError_t cudaGraphicsUnmapResources(int count,
                                       cudaGraphicsResource_t* resources,
                                       cudaStream_t stream);
cudaError_t cudaGraphicsSubResourceGetMappedArray(cudaArray_t* array,
                                                  cudaGraphicsResource_t resource,
                                                  unsigned index,
                                                  unsigned level);
// Offsets and width in bytes, height in rows.
cudaError_t cudaMemcpy2DToArrayAsync(cudaArray_t to,
                                     size_t x,
                                     size_t y,
                                     const void* from,
                                     size_t pitch,
                                     size_t width,
                                     size_t height,
                                     cudaMemcpyKind kind,
                                     cudaStream_t stream);
