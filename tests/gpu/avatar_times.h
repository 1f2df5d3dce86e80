// What an avatar's frames and training steps take on a device, and the CPU beside it.
#pragma once

#include <cstddef>
#include <cstdio>

namespace cosplat::test {

struct AvatarTimes {
  size_t gaussians = 0, triangles = 0;
  int side = 0;                  // px, of a square image
  double pose_ms = 0;            // parameters up, posed vertices on the device
  double frame_ms = 0;           // the same, surface, binding, image on the device
  double frame_to_host_ms = 0;   // the same, and the image down
  double step_ms = 0;            // posed vertices up, a frame, loss, gradients, Adam; any order
  double step_and_track_ms = 0;  // with dL/d(vertices), down
  double cpu_frame_ms = 0;       // the CPU's surface, binding and image of posed vertices
  double psnr = 0;               // of the device's image to the CPU's
};

// Of a made avatar on a mesh of about FLAME's size, another pose in every frame. `tiny`: a few
// hundred Gaussians, once, to see that it works.
AvatarTimes TimeAvatar(bool tiny);

// As a field "avatar" of the object that is being written.
void WriteJson(std::FILE* file, const AvatarTimes& times);

}  // namespace cosplat::test
