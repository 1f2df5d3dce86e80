// The sound of a video that is being written, for video_stream.cpp.
#pragma once

#include <cstdint>
#include <string>

#include "splat/media/libav.h"
#include "splat/media/sound.h"

namespace cosplat::libav {

class SoundTrack {
 public:
  // Adds the track to a file whose header is not yet written. name: for errors. Throws Error if it
  // cannot be encoded.
  SoundTrack(const std::string& name, AVFormatContext& output, Sound sound);
  // Writes what sounds before this moment, and a little more.
  void WriteUntil(double seconds);
  // What the encoder still holds.
  void Finish();

 private:
  void Check(int code) const;
  void Encode(const AVFrame* samples);

  std::string name_;
  AVFormatContext& output_;
  Sound sound_;
  Codec codec_;
  Frame frame_{av_frame_alloc()};
  Packet packet_{av_packet_alloc()};
  AVStream* stream_ = nullptr;
  int64_t written_ = 0;  // samples of a channel
};

}  // namespace cosplat::libav
