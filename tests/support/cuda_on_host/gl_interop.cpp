#include <cstring>
#include <vector>

#include "tests/support/cuda_on_host/cuda_gl_interop.h"

struct CudaOnHostArray {
  int width = 0, height = 0;
  std::vector<char> bytes;  // [height, width, 4]
};
struct CudaOnHostTexture {
  GLuint name = 0;
  bool is_mapped = false;
  CudaOnHostArray array;
};

namespace cuda_on_host {
namespace {

constexpr char kPoison = 0x5a;  // what was there is lost when a texture is mapped to be written

// All of them are called in the thread that has the context.
GlKind kind = GlKind::kOfDevice;
GlCounts counts;

// Binds it.
void SizeOf(GLuint texture, int& width, int& height) {
  if (!glIsTexture(texture)) throw Fault("there is no such texture in this thread's context");
  glBindTexture(GL_TEXTURE_2D, texture);
  GLint format = 0;
  glGetTexLevelParameteriv(GL_TEXTURE_2D, 0, GL_TEXTURE_WIDTH, &width);
  glGetTexLevelParameteriv(GL_TEXTURE_2D, 0, GL_TEXTURE_HEIGHT, &height);
  glGetTexLevelParameteriv(GL_TEXTURE_2D, 0, GL_TEXTURE_INTERNAL_FORMAT, &format);
  if (width == 0 || height == 0 || format != GL_RGBA8)
    throw Fault("a texture without storage for RGBA8");
}

void CheckStorage(const CudaOnHostTexture& texture) {
  int width = 0, height = 0;
  SizeOf(texture.name, width, height);
  if (width != texture.array.width || height != texture.array.height)
    throw Fault("a texture whose storage is another than was registered");
}

}  // namespace

void SetGlKind(GlKind next) { kind = next; }
GlCounts CountsOfGl() { return counts; }
void ResetGl() {
  kind = GlKind::kOfDevice;
  counts = {};
}

}  // namespace cuda_on_host

using cuda_on_host::counts;
using cuda_on_host::Fault;
using cuda_on_host::GlKind;

cudaError_t cudaGLGetDevices(unsigned* count, int* devices, unsigned max, cudaGLDeviceList) {
  if (cuda_on_host::kind == GlKind::kOfAnother || max == 0) return cudaErrorInvalidValue;
  *count = 1;
  devices[0] = 0;
  return cudaSuccess;
}

cudaError_t cudaGraphicsGLRegisterImage(cudaGraphicsResource_t* resource,
                                        GLuint texture,
                                        GLenum target,
                                        unsigned flags) {
  if (target != GL_TEXTURE_2D || flags != cudaGraphicsRegisterFlagsWriteDiscard)
    throw Fault("a registration that the emulation does not know");
  if (cuda_on_host::kind == GlKind::kNotShared) return cudaErrorInvalidValue;
  CudaOnHostTexture made;
  made.name = texture;
  cuda_on_host::SizeOf(texture, made.array.width, made.array.height);
  made.array.bytes.resize(4 * size_t(made.array.width) * size_t(made.array.height));
  *resource = new CudaOnHostTexture(made);
  ++counts.registered;
  ++counts.registrations;
  return cudaSuccess;
}

cudaError_t cudaGraphicsUnregisterResource(cudaGraphicsResource_t resource) {
  cuda_on_host::Finish();
  try {
    cuda_on_host::CheckStorage(*resource);
    if (resource->is_mapped) throw Fault("a texture that is still mapped");
  } catch (const Fault&) {
    ++counts.faults;
  }
  --counts.registered;
  delete resource;
  return cudaSuccess;
}

cudaError_t cudaGraphicsMapResources(int count, cudaGraphicsResource_t* resources, cudaStream_t) {
  for (int i = 0; i < count; ++i) {
    CudaOnHostTexture& texture = *resources[i];
    if (texture.is_mapped) throw Fault("a texture that is mapped twice");
    cuda_on_host::CheckStorage(texture);
    texture.is_mapped = true;
    std::memset(texture.array.bytes.data(), cuda_on_host::kPoison, texture.array.bytes.size());
  }
  return cudaSuccess;
}

cudaError_t cudaGraphicsUnmapResources(int count, cudaGraphicsResource_t* resources, cudaStream_t) {
  cuda_on_host::Finish();
  for (int i = 0; i < count; ++i) {
    CudaOnHostTexture& texture = *resources[i];
    if (!texture.is_mapped) throw Fault("a texture that is not mapped");
    cuda_on_host::CheckStorage(texture);
    texture.is_mapped = false;
    const CudaOnHostArray& a = texture.array;
    glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
    glTexSubImage2D(
        GL_TEXTURE_2D, 0, 0, 0, a.width, a.height, GL_RGBA, GL_UNSIGNED_BYTE, a.bytes.data());
  }
  return cudaSuccess;
}

cudaError_t cudaGraphicsSubResourceGetMappedArray(cudaArray_t* array,
                                                  cudaGraphicsResource_t resource,
                                                  unsigned,
                                                  unsigned) {
  if (!resource->is_mapped) throw Fault("the array of a texture that is not mapped");
  *array = &resource->array;
  return cudaSuccess;
}

cudaError_t cudaMemcpy2DToArrayAsync(cudaArray_t to,
                                     size_t x,
                                     size_t y,
                                     const void* from,
                                     size_t pitch,
                                     size_t width,
                                     size_t height,
                                     cudaMemcpyKind kind,
                                     cudaStream_t) {
  if (cuda_on_host::kind == GlKind::kBreaksOff) return cudaErrorInvalidValue;
  const size_t row = 4 * size_t(to->width);
  if (kind != cudaMemcpyDeviceToDevice || x + width > row || y + height > size_t(to->height) ||
      pitch < width)
    throw Fault("a copy that is not of the array's size");
  cuda_on_host::Enqueue([=] {
    for (size_t r = 0; r < height; ++r)
      std::memcpy(
          to->bytes.data() + (y + r) * row + x, static_cast<const char*>(from) + r * pitch, width);
  });
  ++counts.copies;
  return cudaSuccess;
}
