#include "splat/cuda/photographs.h"

namespace cosplat::cuda {

const DeviceTarget& Photographs::Of(size_t frame, cudaStream_t stream) {
  DeviceTarget& kept = kept_[frame];
  if (!kept.bytes.empty()) return kept;
  const Image8& image = subject_.frame(frame).target;
  const bool fits = held_ + image.data.size() + image.data.size() / kHeadRoom <= most_bytes_;
  DeviceTarget& target = fits ? kept : passing_;
  target.ResizeLike(image);
  staging_.Send(image.data.data(), image.data.size(), target.bytes.data(), stream);
  if (fits) held_ += target.bytes.capacity();
  return target;
}

}  // namespace cosplat::cuda
