// Conversion between the cameras of cosplat.h and of the renderer, and the orbit camera.
#pragma once

#include <array>

#include "avatar/plugin/cosplat.h"
#include "splat/base/camera.h"

namespace cosplat::plugin {

// Throws CodedError unless both sides and the number of pixels are within the limits of cosplat.h.
void CheckSize(uint32_t width, uint32_t height, const char* name);

// Throws CodedError naming the field when a number is not finite or out of range, or the matrix is
// no rotation. The returned rotation is orthonormal.
Camera ToCamera(const cosplat_camera& given);
cosplat_camera FromCamera(const Camera& camera);

// The centre of the orbit: the resting head.
struct OrbitTarget {
  std::array<float, 3> center{};                             // world, metres
  float extent = 0;                                          // metres, its larger side
  std::array<float, 9> rotation{1, 0, 0, 0, 1, 0, 0, 0, 1};  // world_from_flame, row-major
};

struct Orbit {
  float azimuth = 0, elevation = 0;  // radians
  float zoom = 1;
};

// The camera of cosplat_orbit_camera. Throws CodedError as CheckSize does, and on a number out of
// range.
Camera OrbitCamera(const OrbitTarget& target, uint32_t width, uint32_t height, const Orbit& orbit);

}  // namespace cosplat::plugin
