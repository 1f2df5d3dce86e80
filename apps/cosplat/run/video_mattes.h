// Mattes for the frames of a video: people's own, or a network's, refined.
//
// `cosplat landmarks` writes them beside the landmarks.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "apps/cosplat/run/frame_source.h"
#include "flame/io/landmarks.h"
#include "splat/media/refine_mattes.h"

namespace cosplat {

// Mattes that somebody made of a video: a folder of images, named as the frames are or in their
// order, or a grey video.
class OwnMattes {
 public:
  // Throws Error naming `path` if there is not one for each of `frames`, of their size.
  OwnMattes(const std::string& path, const FrameSource& frames);
  // From here on they are this part of the frames.
  void CropTo(const FrameCrop& crop) { mattes_.CropTo(crop); }
  // 1 channel, 255 where the person is. Cheapest in order.
  Image8 Read(int frame) const;

 private:
  FrameSource mattes_;
  bool is_video_;
  std::vector<int> place_;  // per frame, in mattes_
};

// Where a frame's face is: its points' extent. Nothing without a face.
std::optional<FaceBox> FaceBoxOf(const LandmarkFrame& frame);

// Refines mattes of a network of 256x256 pixels over `video`'s frames (flame/io/landmarks.h), which
// `image` and `matte` return by their place in it, from several threads.
MatteRefiner RefinerOf(const LandmarkVideo& video,
                       std::function<Image8(int)> image,
                       std::function<Image8(int)> matte);

}  // namespace cosplat
