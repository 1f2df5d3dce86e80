#include "apps/viewer/timeline.h"

#include <algorithm>
#include <cmath>

namespace cosplat::viewer {

void Timeline::Advance(double seconds) {
  if (!playing_ || frames_ == 0) return;
  position_ += seconds * frames_per_second_ * speed;
  if (position_ < frames_) return;
  if (loops) {
    position_ = std::fmod(position_, double(frames_));
  } else {
    Seek(frames_ - 1);
    Pause();
  }
}

void Timeline::Toggle() {
  if (playing_) return Pause();
  if (!loops && frame() == frames_ - 1) Seek(0);
  Play();
}

void Timeline::Seek(int frame) { position_ = std::clamp(frame, 0, std::max(frames_ - 1, 0)); }

void Timeline::Step(int frames) {
  Pause();
  Seek(frame() + frames);
}

}  // namespace cosplat::viewer
