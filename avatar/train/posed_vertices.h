// A cache of the training frames' posed vertices in a stream's memory.
//
// 12 bytes per vertex and frame: 60 kB for a frame of FLAME's 5,023 vertices. Frames beyond the
// limit are posed and sent every time they are needed.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "splat/device/buffer.h"

namespace cosplat {

class PosedVertices {
 public:
  PosedVertices() = default;
  // Caches as many of the first frames as fit into `limit` bytes.
  PosedVertices(size_t frames, size_t vertex_count, size_t limit)
      : frame_numbers_(3 * vertex_count),
        sent_(std::min(frames, limit / (frame_numbers_ * sizeof(float)))) {}

  // pose() -> const std::vector<float>& [V, 3] is called if the frame is not cached yet.
  template <class Pose>
  View<float> Of(size_t frame, const Pose& pose, Stream& stream) {
    if (frame >= sent_.size()) {
      const std::vector<float>& vertices = pose();
      passing_.Refill(frame_numbers_, stream);
      stream.Send(passing_.data(), vertices.data(), frame_numbers_ * sizeof(float));
      return passing_.view();
    }
    if (kept_.empty()) kept_.Refill(frame_numbers_ * sent_.size(), stream);
    float* row = kept_.data() + frame_numbers_ * frame;
    if (!sent_[frame]) {
      stream.Send(row, pose().data(), frame_numbers_ * sizeof(float));
      sent_[frame] = true;
    }
    return {row, frame_numbers_};
  }
  size_t kept_frames() const { return sent_.size(); }
  size_t allocated_bytes() const { return AllocatedBytes(kept_, passing_); }

 private:
  size_t frame_numbers_ = 0;
  std::vector<bool> sent_;
  Buffer<float> kept_, passing_;
};

}  // namespace cosplat
