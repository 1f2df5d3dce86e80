// Where a recorded sequence stands: play, pause, loop, speed, scrub.
#pragma once

namespace cosplat::viewer {

class Timeline {
 public:
  Timeline() = default;  // of no sequence
  Timeline(int frames, double frames_per_second)
      : frames_(frames), frames_per_second_(frames_per_second) {}

  // `seconds` of wall time later. Stops at the last frame unless it loops.
  void Advance(double seconds);
  void Play() { playing_ = frames_ > 0; }
  void Pause() { playing_ = false; }
  // Begins again where it stood at the end.
  void Toggle();
  // To a frame, held within the sequence.
  void Seek(int frame);
  // To a frame beside this one, and pauses.
  void Step(int frames);

  int frames() const { return frames_; }
  int frame() const { return int(position_); }
  double seconds() const { return frames_ > 0 ? position_ / frames_per_second_ : 0; }
  bool playing() const { return playing_; }
  bool loops = true;
  float speed = 1;  // >= 0

 private:
  int frames_ = 0;
  double frames_per_second_ = 25;
  double position_ = 0;  // [0, frames_)
  bool playing_ = false;
};

}  // namespace cosplat::viewer
