// splat/render/device_texture.h on a CUDA device: OpenGL interoperability.
//
// A library of its own (cosplat::cuda_gl), since it needs OpenGL's header. Source: CUDA Runtime
// API, "Graphics Interoperability" and "OpenGL Interoperability".
#pragma once

#include "splat/render/device_texture.h"

namespace cosplat::cuda {

std::unique_ptr<DeviceTexture> MakeGlTexture(unsigned texture);

}  // namespace cosplat::cuda
