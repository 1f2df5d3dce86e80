// Training frames as they would look with a wider field, which shows what is beyond their borders:
// there the person fades out. Otherwise a viewer with a taller window sees whatever Gaussians that
// no frame shows happen to look like.
//
// FilmedBoxOf -> ToWideView -> frames to train on besides the others.
#pragma once

#include <cstddef>
#include <vector>

#include "avatar/surface/silhouette.h"
#include "avatar/train/mesh_in_frame.h"
#include "splat/base/camera.h"
#include "splat/train/subject/subject.h"

namespace cosplat {

// 1 in the image, falling to 0 some centimetres beyond its border. scale: size of this head, 1 for
// the template's.
float InFrameShare(const Camera& camera, const ImagePoint& at, float scale);

struct BodyInFrame {
  const TrainFrame* frame = nullptr;  // with alpha
  math::Vec3<float> anchor;           // metres, world: where the body is that borders cut off
};
// What the images of all frames show between them, around the body and at its depth: metres, to the
// right and downwards.
struct FilmedBox {
  float left = 0, right = 0, top = 0, bottom = 0;
};
// frames: at least one; the bodies are before their cameras.
FilmedBox FilmedBoxOf(const std::vector<BodyInFrame>& frames);

// Whether the person reaches the border of some frame.
bool ReachesBorder(const TrainFrame& frame);

// The frame, by its camera with a wider field: ignored is what is in `box`, and beyond it the
// colours of the image's border fade out.
TrainFrame ToWideView(const BodyInFrame& source, const FilmedBox& box, float scale);

}  // namespace cosplat
