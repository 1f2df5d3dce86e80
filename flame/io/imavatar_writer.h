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

// A track that says which model it is of.
TrackedVideo TrackOf(const FlameModel& model);

// Writes <folder>/flame_params.json atomically: the frames in track.train, whose cameras must have
// one lens and whose expressions one length. A frame's eyelids, if any frame has some, are written
// as "eyelids", the subject's static offset as "static_offset", the model's vertices as "vertices",
// its hash as "model_sha256"; the layout's other readers ignore them. boxes: [frames] ImavatarBox.
// The last test_frames are held out; -1: the reader decides. Throws Error if the file cannot be
// written.
void WriteImavatarTrack(const std::string& folder,
                        const TrackedVideo& track,
                        const std::vector<std::array<float, 4>>& boxes,
                        int test_frames = -1);

}  // namespace cosplat
