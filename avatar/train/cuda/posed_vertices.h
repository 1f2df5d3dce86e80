// Posed vertices of the frames of a training, kept on the device once they were sent there.
//
// 12 bytes per vertex and frame: 60 kB for a frame of FLAME's 5,023 vertices. Frames beyond the
// limit are posed and sent each time that they are wanted.
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "splat/device/cuda/staging.h"
#include "splat/device/memory_part.h"

namespace cosplat::cuda {

class PosedVertices {
 public:
  // Keeps the first frames, as many as `limit` bytes hold.
  PosedVertices(size_t frames, size_t vertex_count, size_t limit)
      : frame_numbers_(3 * vertex_count),
        sent_(std::min(frames, limit / (frame_numbers_ * sizeof(float)))) {}

  // pose() -> const std::vector<float>& [V, 3] is called where the frame is not kept.
  template <class Pose>
  const float* Of(size_t frame, const Pose& pose, cudaStream_t stream) {
    if (frame >= sent_.size()) {
      const std::vector<float>& vertices = pose();
      passing_.Refill(frame_numbers_);
      Send(vertices, passing_.data(), stream);
      return passing_.data();
    }
    if (kept_.empty()) kept_.Refill(frame_numbers_ * sent_.size());
    float* row = kept_.data() + frame_numbers_ * frame;
    if (!sent_[frame]) {
      Send(pose(), row, stream);
      sent_[frame] = true;
    }
    return row;
  }
  size_t kept_frames() const { return sent_.size(); }
  size_t held() const { return HeldBy(kept_, passing_); }

 private:
  void Send(const std::vector<float>& vertices, float* to, cudaStream_t stream) {
    staging_.Send(vertices.data(), frame_numbers_ * sizeof(float), to, stream);
  }

  size_t frame_numbers_;
  std::vector<bool> sent_;
  DeviceBuffer<float> kept_, passing_;
  Staging staging_;
};

}  // namespace cosplat::cuda
