// Writes a track in IMavatar's layout, which flame/io/imavatar.cpp reads: flame_params.json beside
// image/NAME.png and mask/NAME.png, which the caller writes.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "flame/track.h"

namespace cosplat {

// Extent of a mask's non-zero pixels in the layout's form: left, top, right, bottom in [-1, 1].
std::array<float, 4> ImavatarBox(const Image8& mask);

struct ImavatarTrack {
  int vertices = 0;          // of the model, FlameModel::own_vertex_count; 0: not said
  std::string model_sha256;  // its FlameModel::sha256 if it is not FLAME; empty: not said
  std::vector<float> shape;
  std::vector<float> static_offset;         // [V, 3] metres, or empty
  int test_frames = -1;                     // the last ones are held out; -1: the reader decides
  std::vector<TrackedFrame> frames;         // name, camera and params; all cameras have one lens
  std::vector<std::array<float, 4>> boxes;  // [frames] ImavatarBox
};

// A track that says which model it is of.
ImavatarTrack ImavatarTrackOf(const FlameModel& model);

// Writes <folder>/flame_params.json atomically. A frame's eyelids, if any frame has some, are
// written as "eyelids", the subject's static offset as "static_offset", the model's vertices as
// "vertices", its hash as "model_sha256"; the layout's other readers ignore them. Frames'
// expressions must have one length. Throws Error if the file cannot be written.
void WriteImavatarTrack(const std::string& folder, const ImavatarTrack& track);

}  // namespace cosplat
