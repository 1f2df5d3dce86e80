// Sound of files, by FFmpeg's libraries.
#pragma once

#include <string>
#include <vector>

namespace cosplat {

struct Sound {
  int rate = 0;  // samples per second, of each channel
  int channels = 0;
  std::vector<float> samples;      // -1 to 1, the channels of a moment side by side
  std::vector<std::string> notes;  // what a user should know of how it was read
};

// The first audio track of a sound or video file, converted to `rate` and `channels` (1 or 2).
// Damaged parts are left out; a video's track that begins later begins with silence. Throws Error
// if the file cannot be opened, has no audio track or none that can be decoded.
Sound ReadSound(const std::string& path, int rate, int channels);

}  // namespace cosplat
