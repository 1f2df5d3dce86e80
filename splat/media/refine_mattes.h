// Mattes of a network of low resolution, made as sharp as the images of the video.
//
// A segmentation network's mattes, where the face is, and the frames -> MatteRefiner -> mattes as
// `cosplat landmarks` writes them.
#pragma once

#include <functional>
#include <optional>

#include "splat/base/image.h"
#include "splat/media/face_part.h"
#include "splat/media/still_background.h"

namespace cosplat {

struct MatteVideo {
  int frames = 0;
  // By the frame's number from 0, all of one size; called from several threads.
  std::function<Image8(int)> image;  // RGB
  std::function<Image8(int)> matte;  // 1 channel, 255 where the person is
  std::function<std::optional<FaceBox>(int)> face;
  // How many pixels of the image a pixel of the network spans, >= 1: mattes are wrong by so much.
  double network_px = 2;
};

// Refines a matte
//  1. without what never moves where the network hesitates (lecterns; FindStillThings);
//  2. to the part that has the face (the largest one without a face), without holes in the face;
//  3. near its rim by the guided filter of the frame: by which colours are inside and outside;
//  4. where the background stands still and is seen past the person in other frames, by the
//     pixel's difference from it: near the rim, and where the network hesitates.
// Thread-safe; the same bits for any number of threads.
class MatteRefiner {
 public:
  // Looks at some of the frames, for their background.
  explicit MatteRefiner(const MatteVideo& video);
  Image8 Refine(int frame) const;

 private:
  MatteVideo video_;
  Image8 things_;
  StillBackground background_;
};

}  // namespace cosplat
