// Training frames as they would look with the mouth open wider than in any.
//
// A video in which somebody talks shows the mouth nearly shut. Gaussians of one lip that reach over
// the other, or stand for teeth between them, become a torn lump when it opens. The mesh knows how
// lips part, and deep between them it is dark.
//
// ChooseVirtualFaces -> ToVirtualFace -> frames to train on besides the others, as virtual views
// (virtual_views.h) are.
#pragma once

#include <optional>
#include <vector>

#include "avatar/model/avatar_mesh.h"
#include "avatar/train/mesh_in_frame.h"
#include "avatar/train/painted_mesh.h"
#include "flame/model.h"
#include "splat/base/camera.h"
#include "splat/train/subject/subject.h"

namespace cosplat {

struct VirtualFace {
  size_t source = 0;  // frame, whose camera and head pose it has
  AvatarPoser::Parameters params;
};

struct VirtualFaces {
  std::vector<VirtualFace> faces;
  // Metres from the lips, within which frames show what is between them.
  float known = 0;
};

// At most `count` faces with an open mouth, fewer the wider it opens in the frames. track: of the
// training frames, at least one. cameras: theirs. None if the model has nothing behind its
// teeth (flame/mouth.h).
VirtualFaces ChooseVirtualFaces(const FlameModel& flame,
                                AvatarPoser& poser,
                                const std::vector<AvatarPoser::Parameters>& track,
                                const std::vector<Camera>& cameras,
                                size_t count);

// source: the frame, with alpha. vertices: [V, 3] of the other face, in its place. Shows the lips,
// as the frame does, and the dark behind the teeth, farther than `known` from the lips; all else is
// ignored. Nothing if there is nothing to show.
std::optional<TrainFrame> ToVirtualFace(const MeshInFrame& source,
                                        const std::vector<float>& vertices,
                                        float known,
                                        const PaintedMesh& painted);

}  // namespace cosplat
