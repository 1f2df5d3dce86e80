// An encoder and a container by FFmpeg's libraries, for video_writer.cpp and live_video.cpp.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "splat/base/image.h"
#include "splat/media/libav.h"
#include "splat/media/sound_track.h"

namespace cosplat::libav {

struct CloseOutput {
  void operator()(AVFormatContext* output) const {
    if (output->pb != nullptr) avio_closep(&output->pb);
    avformat_free_context(output);
  }
};
using Output = std::unique_ptr<AVFormatContext, CloseOutput>;

// What FFmpeg's scaler makes of RGB images: 4:2:0, BT.601, of even size; an odd last row or column
// is dropped.
class Yuv420 {
 public:
  // Throws Error naming `name`.
  Yuv420(const std::string& name, int width, int height);
  // rgb: of the size given. Valid until the next call.
  AVFrame* Of(const Image8& rgb);

 private:
  std::string name_;
  int width_, height_, written_ = 0;
  Frame frame_{av_frame_alloc()};
  Scaler scaler_;
};

class VideoStream {
 public:
  enum class For {
    kFile,  // at a quality at which frames are hard to tell from what was written
    kLive   // without delay, at what a connection can carry
  };
  // name: for errors. container: FFmpeg's name. sound: beside the images, from the first. Throws
  // Error if it cannot be opened.
  VideoStream(const std::string& name,
              const std::string& container,
              const std::string& url,
              int width,
              int height,
              double frames_per_second,
              For purpose,
              std::optional<Sound> sound = {});
  // number: of the frame, from 0, increasing; frames may be left out.
  void Write(const Image8& rgb, int64_t number);
  void Finish();

 private:
  // `code`: what a function of FFmpeg returned.
  void Check(int code) const;
  // A null image: what the encoder still holds.
  void Encode(const AVFrame* image);

  std::string name_;
  Output output_;
  Codec codec_;
  Packet packet_{av_packet_alloc()};
  Yuv420 yuv_;
  std::optional<SoundTrack> sound_;
  AVStream* stream_ = nullptr;
};

}  // namespace cosplat::libav
