// The target images that are trained on, as bytes on the device.
#pragma once

#include <vector>

#include "splat/device/cuda/staging.h"
#include "splat/train/cuda/loss.h"
#include "splat/train/reduced_frames.h"

namespace cosplat::cuda {

class TargetImages {
 public:
  // Keeps up to `most_bytes` of them there, each from its first use on; what is beyond that is sent
  // again with each step.
  TargetImages(const Subject& subject, size_t most_bytes)
      : frames_(subject), most_bytes_(most_bytes), kept_(subject.frame_count()) {}

  // downscale: as ReducedFrames::At's. Those of one are there at a time.
  const Camera& CameraOf(size_t frame, int downscale) {
    return frames_.At(frame, downscale).camera;
  }
  const DeviceTarget& Of(size_t frame, int downscale, cudaStream_t stream);
  size_t held() const { return held_ + passing_.bytes.capacity(); }

 private:
  ReducedFrames frames_;
  int downscale_ = 1;
  size_t most_bytes_, held_ = 0;
  std::vector<DeviceTarget> kept_;  // [frames] empty: not there
  DeviceTarget passing_;
  Staging staging_;
};

}  // namespace cosplat::cuda
