#include "splat/train/reduced_frames.h"

#include <utility>

namespace cosplat {

TrainFrame Reduced(const TrainFrame& frame, int downscale) {
  const Image8& from = frame.target;
  const int channels = from.channels, d = downscale;
  TrainFrame reduced{frame.camera, Image8(from.width / d, from.height / d, channels), {}};
  Camera& camera = reduced.camera;
  camera.width = reduced.target.width;
  camera.height = reduced.target.height;
  for (float* length : {&camera.fx, &camera.fy, &camera.cx, &camera.cy}) *length /= float(d);
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x) {
      uint64_t sum[4] = {}, weights = 0;
      for (int k = 0; k < d * d; ++k) {
        const uint8_t* pixel = &from.at(x * d + k % d, y * d + k / d, 0);
        const uint64_t weight = channels == 4 ? pixel[3] : 1;
        weights += weight;
        for (int c = 0; c < channels; ++c) sum[c] += (c == 3 ? 1 : weight) * pixel[c];
      }
      for (int c = 0; c < channels; ++c) {
        const uint64_t of = c == 3 ? uint64_t(d) * d : weights;
        reduced.target.at(x, y, c) = of == 0 ? 0 : uint8_t((sum[c] + of / 2) / of);
      }
    }
  if (frame.ignored.empty()) return reduced;
  reduced.ignored = Image8(camera.width, camera.height, 1);
  for (int y = 0; y < camera.height * d; ++y)
    for (int x = 0; x < camera.width * d; ++x)
      reduced.ignored.at(x / d, y / d, 0) |= frame.ignored.at(x, y, 0);
  return reduced;
}

const TrainFrame& ReducedFrames::At(size_t i, int downscale) {
  if (std::exchange(downscale_, downscale) != downscale) {
    reduced_ = {};
    held_ = 0;
  }
  if (downscale == 1) return subject_.frame(i);
  reduced_.resize(subject_.frame_count());
  if (reduced_[i].target.empty()) {
    reduced_[i] = Reduced(subject_.frame(i), downscale);
    held_ += reduced_[i].target.data.capacity() + reduced_[i].ignored.data.capacity();
  }
  return reduced_[i];
}

}  // namespace cosplat
