#include "splat/train/subject/target_store.h"

#include <utility>

namespace cosplat {

TargetView TargetStore::Of(size_t frame, int downscale, Stream& stream) {
  const TrainFrame& from = frames_.At(frame, downscale);
  const Image8& image = from.target;
  const std::vector<uint8_t>& ignored = from.ignored.data;
  const auto view_at = [&](const uint8_t* bytes, const uint8_t* of_ignored) {
    return TargetView{
        image.width, image.height, image.channels, bytes, ignored.empty() ? nullptr : of_ignored};
  };
  const size_t of_image = image.data.size();
  if (stream.on_host()) return view_at(image.data.data(), ignored.data());
  if (std::exchange(downscale_, downscale) != downscale) {
    kept_ = std::vector<Buffer<uint8_t>>(kept_.size());  // freeing waits for the device
    bytes_ = 0;
  }
  Buffer<uint8_t>& kept = kept_[frame];
  if (!kept.empty()) return view_at(kept.data(), kept.data() + of_image);
  const size_t bytes = of_image + ignored.size();
  const bool fits = bytes_ + bytes + bytes / kHeadRoom <= max_bytes_;
  Buffer<uint8_t>& target = fits ? kept : passing_;
  target.Refill(bytes, stream);
  stream.Send(target.data(), image.data.data(), of_image);
  if (!ignored.empty()) stream.Send(target.data() + of_image, ignored.data(), ignored.size());
  if (fits) bytes_ += target.capacity();
  return view_at(target.data(), target.data() + of_image);
}

}  // namespace cosplat
