// MediaPipe's face mesh and selfie segmentation over a series of images, in headless Chromium
// (apps/landmarks/detect.mjs).
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "apps/cosplat/run/mediapipe.h"
#include "flame/io/landmarks.h"
#include "splat/base/image.h"

namespace cosplat {

class FaceDetector {
 public:
  // For images of one size, px. Throws Error as FindMediapipe does.
  FaceDetector(int width, int height, bool quiet);
  ~FaceDetector();
  FaceDetector(const FaceDetector&) = delete;
  FaceDetector& operator=(const FaceDetector&) = delete;

  // Images are 0 ... in their order, with 3 channels: alpha would hide what is under it. Calls for
  // different images may run at once.
  void Add(size_t image, const Image8& pixels) const;
  // Looks at all of them. milliseconds: [images] when each was taken, increasing. mattes: for
  // these, too; else two processes share the images, of which none should follow another (within
  // 200 ms). progress: called with how many are done. Throws Error if a program fails.
  void Run(const std::vector<double>& milliseconds,
           bool mattes,
           const std::function<void(int done)>& progress);
  // [images] of all faces in each, px.
  std::vector<std::vector<DetectedFace>> Faces() const;
  // 1 channel, 255 where the person is.
  Image8 Matte(size_t image) const;
  // As it was looked at.
  Image8 Added(size_t image) const;

 private:
  std::string File(const std::string& name) const { return folder_ + "/" + name; }

  int width_, height_;
  Mediapipe mediapipe_;
  std::string folder_;  // of the images; removed in the end
};

}  // namespace cosplat
