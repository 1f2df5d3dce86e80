#include "splat/train/target_store.h"

#include <utility>

namespace cosplat {

TargetView TargetStore::Of(size_t frame, int downscale, Stream& stream) {
  const Image8& image = frames_.At(frame, downscale).target;
  TargetView view{image.width, image.height, image.channels, image.data.data()};
  if (stream.on_host()) return view;
  if (std::exchange(downscale_, downscale) != downscale) {
    kept_ = std::vector<Buffer<uint8_t>>(kept_.size());  // freeing waits for the device
    held_ = 0;
  }
  Buffer<uint8_t>& kept = kept_[frame];
  if (!kept.empty()) {
    view.bytes = kept.data();
    return view;
  }
  const size_t bytes = image.data.size();
  const bool fits = held_ + bytes + bytes / kHeadRoom <= most_bytes_;
  Buffer<uint8_t>& target = fits ? kept : passing_;
  target.Refill(bytes, stream);
  stream.Send(target.data(), image.data.data(), bytes);
  if (fits) held_ += target.capacity();
  view.bytes = target.data();
  return view;
}

}  // namespace cosplat
