#include "splat/train/cuda/target_images.h"

#include <utility>

namespace cosplat::cuda {

const DeviceTarget& TargetImages::Of(size_t frame, int downscale, cudaStream_t stream) {
  if (std::exchange(downscale_, downscale) != downscale) {
    kept_ = std::vector<DeviceTarget>(kept_.size());  // freeing waits for the device
    held_ = 0;
  }
  DeviceTarget& kept = kept_[frame];
  if (!kept.bytes.empty()) return kept;
  const Image8& image = frames_.At(frame, downscale).target;
  const bool fits = held_ + image.data.size() + image.data.size() / kHeadRoom <= most_bytes_;
  DeviceTarget& target = fits ? kept : passing_;
  target.ResizeLike(image);
  staging_.Send(image.data.data(), image.data.size(), target.bytes.data(), stream);
  if (fits) held_ += target.bytes.capacity();
  return target;
}

}  // namespace cosplat::cuda
