// Cameras of cosplat.h and of the renderer, and one that circles a head.
#pragma once

#include <array>

#include "avatar/plugin/cosplat.h"
#include "splat/base/camera.h"

namespace cosplat::plugin {

// Throws CodedError unless both sides and the number of pixels are within what cosplat.h says.
void CheckSize(uint32_t width, uint32_t height, const char* name);

// Throws CodedError naming the field when a number is not finite or out of its range, or the
// rotation is none; makes it orthonormal.
Camera ToCamera(const cosplat_camera& given);
cosplat_camera FromCamera(const Camera& camera);

// What an orbit goes around: the resting head.
struct OrbitTarget {
  std::array<float, 3> center{};                             // world, metres
  float extent = 0;                                          // metres across
  std::array<float, 9> rotation{1, 0, 0, 0, 1, 0, 0, 0, 1};  // world_from_flame, row-major
};

struct Orbit {
  float azimuth = 0, elevation = 0;  // radians
  float zoom = 1;
};

// As cosplat_orbit_camera has it. Throws CodedError as CheckSize does, and on a number out of its
// range.
Camera OrbitCamera(const OrbitTarget& target, uint32_t width, uint32_t height, const Orbit& orbit);

}  // namespace cosplat::plugin
