#include "splat/train/subject/reduced_frames.h"

#include <string>
#include <utility>

#include "splat/base/error.h"

namespace cosplat {
namespace {

void CheckSize(const TrainFrame& frame, size_t index) {
  const Image8& image = frame.target;
  const Camera& camera = frame.camera;
  if (image.width == camera.width && image.height == camera.height) return;
  throw Error("training frame " + std::to_string(index),
              "the image has " + SizeText(image.width, image.height) + " pixels, its camera " +
                  SizeText(camera.width, camera.height));
}

}  // namespace

Camera Reduced(Camera camera, int downscale) {
  camera.width /= downscale;
  camera.height /= downscale;
  for (float* length : {&camera.fx, &camera.fy, &camera.cx, &camera.cy})
    *length /= float(downscale);
  return camera;
}

TrainFrame Reduced(const TrainFrame& frame, int downscale) {
  const Image8& from = frame.target;
  const int channels = from.channels, d = downscale;
  const Camera camera = Reduced(frame.camera, d);
  TrainFrame reduced{camera, Image8(camera.width, camera.height, channels), {}};
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
    of_passing_ = size_t(-1);
    bytes_ = 0;
  }
  if (downscale == 1) {
    const TrainFrame& frame = subject_.frame(i);
    CheckSize(frame, i);
    return frame;
  }
  reduced_.resize(subject_.frame_count());
  if (!reduced_[i].target.empty()) return reduced_[i];
  if (of_passing_ == i) return passing_;
  const TrainFrame& frame = subject_.frame(i);
  CheckSize(frame, i);
  TrainFrame reduced = Reduced(frame, downscale);
  const size_t bytes = reduced.target.data.capacity() + reduced.ignored.data.capacity();
  if (bytes_ + bytes > subject_.max_reduced_bytes()) {
    of_passing_ = i;
    return passing_ = std::move(reduced);
  }
  bytes_ += bytes;
  return reduced_[i] = std::move(reduced);
}

}  // namespace cosplat
