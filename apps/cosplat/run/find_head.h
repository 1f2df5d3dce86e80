// Which frames of a video, and which part of them, show one head?
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "apps/cosplat/run/frame_source.h"
#include "flame/io/landmarks.h"

namespace cosplat {

struct FoundHead {
  std::vector<int> frames;         // increasing: those of all shots that are alike (ShotsAlike)
  std::optional<FrameCrop> crop;   // none where the frames are no larger than it would be
  std::vector<std::string> notes;  // what a user should know: that shots are left out
  // Of the frames looked at, increasing, those that show the head, and where: px of the frame.
  std::vector<std::pair<int, FaceBox>> seen;
  bool is_alone = true;  // no other person is seen in them (flame/fit/choose_person.h)

  // Of each of `frames`, increasing, where the nearest of them saw the head, px of the crop. Empty
  // if none was looked at.
  std::vector<FaceBox> ExpectedIn(const std::vector<int>& frames) const;
};

// size: px, of HeadCrop; 0: no crop. Shows progress unless quiet. Throws Error naming `source` if
// there is no face in the frames that are looked at, and as FaceDetector does.
FoundHead FindHead(const std::string& source, const FrameSource& frames, int size, bool quiet);

}  // namespace cosplat
