// Finds the landmarks of a video's faces, and mattes, by MediaPipe in headless Chromium.
//
// FrameSource -> apps/landmarks/detect.mjs (node, Chromium) -> a landmark file with its mattes,
// which `cosplat track` reads.
#pragma once

#include <string>

namespace cosplat {

struct LandmarkRunOptions {
  std::string source;  // a video, or a folder of images
  std::string out;     // .json; mattes go into mattes/ beside it
  bool quiet = false;
};

// The first use installs MediaPipe's packages by npm into the user's cache folder, and says so;
// later ones need no network. Shows progress and prints a summary. Throws Error that says what to
// install if node, npm or Chromium is missing, and if one of them fails or no frame has a face;
// nothing is written then.
void DetectLandmarks(const LandmarkRunOptions& options);

}  // namespace cosplat
