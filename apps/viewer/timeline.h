// Playback position of a recorded sequence: play, pause, loop, speed, scrub.
#pragma once

namespace cosplat::viewer {

class Timeline {
 public:
  Timeline() = default;  // without a sequence
  Timeline(int frames, double frames_per_second)
      : frames_(frames), frames_per_second_(frames_per_second) {}

  // Advances by `seconds` of wall time. Stops at the last frame unless looping.
  void Advance(double seconds);
  void Play() { playing_ = frames_ > 0; }
  void Pause() { playing_ = false; }
  // Plays or pauses; restarts if it stopped at the end.
  void Toggle();
  // Jumps to a frame, clamped to the sequence.
  void Seek(int frame);
  // Moves by `frames` and pauses.
  void Step(int frames);

  int frames() const { return frames_; }
  double frames_per_second() const { return frames_per_second_; }
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
