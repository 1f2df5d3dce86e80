// Images to who looks at them now: a virtual camera, or a server of streams.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "splat/base/image.h"

namespace cosplat {

class LiveVideo {
 public:
  virtual ~LiveVideo() = default;
  // rgb: of the size given. number: of the frame at the rate given, from 0, increasing; numbers may
  // be left out. Throws Error if nobody takes it any more.
  virtual void Write(const Image8& rgb, int64_t number) = 0;
};

// to: "v4l2:DEVICE", a video output such as v4l2loopback's, or a pipe in its place that takes the
// frames' bytes (planar 4:2:0, BT.601); or an address for FFmpeg: rtmp:// (FLV), others such as
// srt://, udp://, tcp:// and file: (MPEG-TS). Throws Error naming `to` and what is wrong with it.
// An odd last row or column is dropped.
std::unique_ptr<LiveVideo> OpenLiveVideo(const std::string& to,
                                         int width,
                                         int height,
                                         double frames_per_second);

}  // namespace cosplat
