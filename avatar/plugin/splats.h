// What a page gives to a splat renderer on the GPU: an avatar's or a scene's Gaussians as a camera
// sees them. An addition to cosplat.h for apps/web, compiled for WebAssembly only.
#pragma once

#include <cstdint>

#include "avatar/plugin/cosplat.h"
#include "splat/render/view_splats.h"

// Output, but for the size. The arrays are the library's.
struct cosplat_splats {
  uint32_t struct_size;
  uint32_t width, height;  // the camera, as cosplat_camera
  float fx, fy, cx, cy;
  float cam_from_world[12];
  uint32_t count;
  const float *centers, *colors, *scales, *rotations;  // [count, 4] each, as of ViewSplats
};

// The face that cosplat_render would draw now, by the camera that was set (COSPLAT_ERROR_NOT_FOUND
// if none was). blur_variance: as FillViewSplats. The arrays are valid until the next call for any
// avatar.
extern "C" cosplat_status cosplat_get_splats(cosplat_avatar* avatar,
                                             float blur_variance,
                                             cosplat_splats* splats);

namespace cosplat::plugin {

// FillViewSplats, with the result also as the structure, which points into `memory`.
void WriteSplats(const WorldGaussians& gaussians,
                 Basis basis,
                 int degree,
                 const Camera& camera,
                 float blur_variance,
                 ViewSplats& memory,
                 cosplat_splats& out);

}  // namespace cosplat::plugin
