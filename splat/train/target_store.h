// The target images that are trained on, as bytes in a stream's memory.
#pragma once

#include <vector>

#include "splat/train/loss.h"
#include "splat/train/reduced_frames.h"

namespace cosplat {

class TargetStore {
 public:
  // A device keeps up to `most_bytes` of them, each from its first use on; what is beyond that is
  // sent again with each step.
  TargetStore(const Subject& subject, size_t most_bytes)
      : frames_(subject), most_bytes_(most_bytes), kept_(subject.frame_count()) {}

  // downscale: as ReducedFrames::At's. Those of one are there at a time.
  const Camera& CameraOf(size_t frame, int downscale) {
    return frames_.At(frame, downscale).camera;
  }
  TargetView Of(size_t frame, int downscale, Stream& stream);
  // Bytes, of all and of smaller ones on the host.
  size_t held() const { return held_ + HeldBy(passing_); }
  size_t HeldForReduced() const { return frames_.held(); }

 private:
  ReducedFrames frames_;
  int downscale_ = 1;
  size_t most_bytes_, held_ = 0;
  std::vector<Buffer<uint8_t>> kept_;  // [frames] empty: not there
  Buffer<uint8_t> passing_;
};

}  // namespace cosplat
