// Target images of training, as bytes in a stream's memory.
#pragma once

#include <vector>

#include "splat/train/loss/loss.h"
#include "splat/train/subject/reduced_frames.h"

namespace cosplat {

class TargetStore {
 public:
  // On a device, up to `max_bytes` of images are kept, each from its first use on; images beyond
  // that are sent again with each step.
  TargetStore(const Subject& subject, size_t max_bytes)
      : frames_(subject), max_bytes_(max_bytes), kept_(subject.frame_count()) {}

  // downscale: as in ReducedFrames::At. Only the images of one downscale are kept at a time.

  // In host memory. Valid until another downscale is requested.
  const Image8& ImageOf(size_t frame, int downscale) { return frames_.At(frame, downscale).target; }
  const FrameLayers& LayersOf(size_t frame, int downscale) {
    return frames_.At(frame, downscale).layers;
  }
  TargetView Of(size_t frame, int downscale, Stream& stream);
  // Bytes, of the images on a device and of the reduced images on the host.
  size_t allocated_bytes() const { return bytes_ + AllocatedBytes(passing_); }
  size_t ReducedBytes() const { return frames_.allocated_bytes(); }

 private:
  ReducedFrames frames_;
  int downscale_ = 1;
  size_t max_bytes_, bytes_ = 0;
  std::vector<Buffer<uint8_t>> kept_;  // [frames] empty: not kept
  Buffer<uint8_t> passing_;
};

}  // namespace cosplat
