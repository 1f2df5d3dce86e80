// Posing in a stream's memory, for playback: a frame whose joints are posed -> posed vertices, by
// FlamePoser's formulas (flame/kernels/pose.h).
//
// Player -> FlameRig (a few hundred numbers, sent to the device) -> RigPoser -> Surface.
#pragma once

#include <map>
#include <memory>
#include <mutex>

#include "avatar/model/avatar_model.h"
#include "flame/posing.h"
#include "splat/device/buffer.h"

namespace cosplat {

// The data from which an avatar's vertices are posed: FLAME's head and the bust.
struct AvatarPosing {
  PosingArrays<float> flame;
  View<const float> bust;  // [K, 3] metres, at its mean place
  math::Vec3<float> bust_pivot{0, 0, 0};
};

// A frame whose joints are posed.
struct AvatarRig {
  FlameRig<float> flame;
  BustPose bust = kMeanBustPose;
  std::vector<float> weights;  // [corrections] (avatar/model/corrections.h)
};

// A model's blend shape directions, most of the data that posing reads: 8 MB for FLAME with 100
// expressions.
struct PosingDirections {
  Buffer<float> expression, pose;
};

// Shares one copy of a model's directions among all avatars posed by the same FlameModel.
// Thread-safe.
class DirectionStore {
 public:
  // Returns the shared copy, creating it if there is none. The model must outlive it.
  std::shared_ptr<const PosingDirections> Get(const PosingArrays<float>& flame, Stream& stream);

 private:
  std::mutex mutex_;
  // By host address, which is unique to a model while a copy of its directions exists.
  std::map<const float*, std::weak_ptr<const PosingDirections>> known_;
};

class RigPoser {
 public:
  // Copies the subject's own arrays and waits for the stream.
  RigPoser(const AvatarPosing& posing, DirectionStore& store, Stream& stream);

  // Returns [vertex_count, 3] metres in the stream's memory, valid until the next call. `rig` must
  // stay unchanged until the stream has been waited for.
  const Buffer<float>& Pose(const AvatarRig& rig, Stream& stream);
  size_t vertex_count() const { return vertices_.size() / 3; }

 private:
  std::shared_ptr<const PosingDirections> directions_;
  Buffer<float> shaped_, weights_, unskinned_;
  Buffer<float> mean_bust_;
  math::Vec3<float> bust_pivot_;
  Buffer<BustPose> bust_pose_;
  Buffer<float> vertices_;  // the bust's come last
  Buffer<DirectionTerm<float>> terms_;
  PosingArrays<float> arrays_;  // in the stream's memory
};

}  // namespace cosplat
