// Posing in a stream's memory, for playback: a frame after its joints -> posed vertices, by
// FlamePoser's formulas (flame/kernels/pose.h).
//
// Player -> FlameRig (some hundred numbers, which go to the device) -> RigPoser -> Surface.
#pragma once

#include <map>
#include <memory>
#include <mutex>

#include "flame/posing.h"
#include "splat/device/buffer.h"

namespace cosplat {

// What an avatar's vertices are posed from: FLAME's head, then the bust, which keeps still.
struct AvatarPosing {
  PosingArrays<float> flame;
  View<const float> bust;  // [K, 3] metres, posed
};

// A model's directions: most of what posing reads. 8 MB of FLAME's with 100 expressions.
struct PosingDirections {
  Buffer<float> expression, pose;
};

// Directions of models, each once for all avatars that are posed by the same FlameModel. Its calls
// may come from several threads.
class DirectionStore {
 public:
  // Copies them where nobody has them. The model must not go before what is returned.
  std::shared_ptr<const PosingDirections> Get(const PosingArrays<float>& flame, Stream& stream);

 private:
  std::mutex mutex_;
  // By where the host has them, which is their model's own place as long as somebody poses by it.
  std::map<const float*, std::weak_ptr<const PosingDirections>> known_;
};

class RigPoser {
 public:
  // Copies the subject's own arrays; waits for the stream.
  RigPoser(const AvatarPosing& posing, DirectionStore& store, Stream& stream);

  // [vertex_count, 3] metres, in the stream's memory, until the next call. `rig` must stay until
  // the stream has been waited for.
  const Buffer<float>& Pose(const FlameRig<float>& rig, Stream& stream);
  size_t vertex_count() const { return vertices_.size() / 3; }

 private:
  std::shared_ptr<const PosingDirections> directions_;
  Buffer<float> shaped_, weights_, unskinned_;
  Buffer<float> vertices_;  // the bust's last, put there once
  Buffer<DirectionTerm<float>> terms_;
  PosingArrays<float> arrays_;  // in the stream's memory
};

}  // namespace cosplat
