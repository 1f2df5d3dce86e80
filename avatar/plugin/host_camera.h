// Conversion between the cameras of cosplat.h and of the renderer, and the orbit camera.
#pragma once

#include "avatar/model/avatar_mesh.h"
#include "avatar/plugin/cosplat.h"
#include "splat/base/camera.h"

namespace cosplat::plugin {

// Throws CodedError unless both sides and the number of pixels are within the limits of cosplat.h.
void CheckSize(uint32_t width, uint32_t height, const char* name);

// Throws CodedError naming the field when a number is not finite or out of range, or the matrix is
// no rotation. The returned rotation is orthonormal.
Camera ToCamera(const cosplat_camera& given);
cosplat_camera FromCamera(const Camera& camera);

struct Orbit {
  float azimuth = 0, elevation = 0;  // radians
  float zoom = 1;
};

// The camera of cosplat_orbit_camera, about the resting head. Throws CodedError as CheckSize does,
// and on a number out of range.
Camera OrbitCamera(const HeadPlace& head, uint32_t width, uint32_t height, const Orbit& orbit);

}  // namespace cosplat::plugin
