// Which frames of a video, and which part of them, show one head?
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "apps/cosplat/run/frame_source.h"
#include "flame/io/landmarks.h"

namespace cosplat {

struct FoundHead {
  std::vector<int> frames;         // increasing: those of all shots that are alike (ShotsAlike)
  std::optional<FrameCrop> crop;   // none where the frames are no larger than it would be
  std::vector<std::string> notes;  // what a user should know: that shots are left out
  double next_person = 0;          // of the frames looked at (flame/fit/choose_person.h)
};

// size: px, of HeadCrop; 0: no crop. Shows progress unless quiet. Throws Error naming `source` if
// there is no face in the frames that are looked at, and as FaceDetector does.
FoundHead FindHead(const std::string& source, const FrameSource& frames, int size, bool quiet);

// Reads frames in their order, some ahead of what is done with them in parallel. i: a place in
// `which`.
void ForFrames(const std::vector<int>& which,
               const std::function<Image8(int frame)>& read,
               const std::function<void(size_t i, const Image8&)>& use,
               const std::function<void(int done)>& progress);

}  // namespace cosplat
