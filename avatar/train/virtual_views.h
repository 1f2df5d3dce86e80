// Training frames as they would look from where no camera was.
//
// A video from the front says nothing of a head's sides, and Gaussians that only have to look right
// from the front become a cloud of needles. The mesh knows more: a frame that is projected onto it
// and seen from aside is a target there, for what the frame shows of it. What no frame shows is
// guessed from what others do (painted_mesh.h), and pixels that may be hair or clothes beyond the
// mesh are ignored.
//
// ChooseVirtualViews, PaintedMesh -> ToVirtualView -> frames to train on besides the others.
#pragma once

#include <vector>

#include "avatar/train/mesh_in_frame.h"
#include "avatar/train/painted_mesh.h"
#include "splat/base/camera.h"
#include "splat/train/subject/subject.h"

namespace cosplat {

struct VirtualView {
  size_t source = 0;  // frame
  Camera camera;      // turned about the head's middle, which stays where it is in the image
};

// A frame's head and the camera that sees it.
struct HeadInFrame {
  math::Vec3<float> center;           // world, metres
  math::Mat3<float> world_from_head;  // in its own axes y is up and the face looks along +z
  Camera camera;
};

// Their yaws and pitches. frames: at least one.
FilmedFrom FilmedFromOf(const std::vector<HeadInFrame>& frames);

// Of `count` directions all around, mostly within 90 degrees of the face, those from which hardly
// any frame sees the head: fewer views, the more it turns before the camera. Their sources are
// frames that see it from near there. frames: at least one.
std::vector<VirtualView> ChooseVirtualViews(const std::vector<HeadInFrame>& frames, size_t count);

// source: the frame of `view`, with alpha.
TrainFrame ToVirtualView(const VirtualView& view,
                         const MeshInFrame& source,
                         const PaintedMesh& painted);

}  // namespace cosplat
