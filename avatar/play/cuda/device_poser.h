// Posing on the device, for playback: a frame after its joints -> posed vertices, by FlamePoser's
// formulas (flame/kernels/pose.h).
//
// Player -> FlameRig (some hundred numbers, which go up) -> DevicePoser -> device_surface.h.
#pragma once

#include <map>
#include <memory>
#include <mutex>

#include "avatar/play/avatar_renderer.h"
#include "splat/device/cuda/memory.h"

namespace cosplat::cuda {

// A model's directions: most of what posing reads. 8 MB of FLAME's with 100 expressions.
struct DeviceDirections {
  DeviceBuffer<float> expression, pose;
};

// Directions of models, each once for all avatars that are posed by the same FlameModel. Its calls
// may come from several threads.
class DirectionStore {
 public:
  // Copies them where nobody has them. The model must not go before what is returned.
  std::shared_ptr<const DeviceDirections> Get(const PosingArrays<float>& flame,
                                              cudaStream_t stream);

 private:
  std::mutex mutex_;
  // By where the host has them, which is their model's own place as long as somebody poses by it.
  std::map<const float*, std::weak_ptr<const DeviceDirections>> known_;
};

class DevicePoser {
 public:
  // Copies the subject's own arrays; waits for the stream.
  DevicePoser(const AvatarPosing& posing, DirectionStore& store, cudaStream_t stream);

  // [vertex_count, 3] metres, on the device, until the next call. `rig` must stay until the stream
  // has been waited for.
  const DeviceBuffer<float>& Pose(const FlameRig<float>& rig, cudaStream_t stream);
  size_t vertex_count() const { return vertices_.size() / 3; }

 private:
  std::shared_ptr<const DeviceDirections> directions_;
  DeviceBuffer<float> shaped_, weights_, unskinned_;
  DeviceBuffer<float> vertices_;  // the bust's last, put there once
  DeviceBuffer<DirectionTerm<float>> terms_;
  PosingArrays<float> arrays_;  // of the device
};

}  // namespace cosplat::cuda
