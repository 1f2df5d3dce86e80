// A camera's face for the page, as `cosplat webcam` has it: a line of apps/landmarks/page/camera.js
// -> CameraFace -> a frame of docs/live-input.md. Called by apps/web/src/avatar.js.
#include <cstdio>
#include <string>

#include "apps/cosplat/run/camera_face.h"
#include "splat/base/error.h"

namespace {

cosplat::CameraFace& Face() {
  static cosplat::CameraFace face;
  return face;
}

}  // namespace

extern "C" {

// The line, valid until the next call; "" while there is no face, or the neutral one is being seen.
const char* cosplat_web_camera_face(const char* line) {
  static std::string packet;
  packet.clear();
  try {
    if (const auto frame = Face().Next(cosplat::ParseCameraFrame(line)))
      packet = cosplat::WriteJsonFrame(*frame);
  } catch (const cosplat::Error& error) {
    std::fprintf(stderr, "cosplat: %s\n", error.what());
  }
  return packet.c_str();
}

// The neutral face is that of the next half second.
void cosplat_web_calibrate() { Face().Calibrate(); }

}  // extern "C"
