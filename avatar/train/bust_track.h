// Where the bust is at each instant of the training video, found from the images below the neck.
//
// RegisterBusts -> BustTrack: PoseBust -> Surface::Pose ... BindBackward -> Advance (Adam).
#pragma once

#include <array>
#include <vector>

#include "avatar/model/avatar_mesh.h"
#include "avatar/surface/binding.h"
#include "avatar/surface/kernels/bust.h"
#include "splat/train/subject/subject.h"

namespace cosplat {

struct BustRates {
  float turn = 5e-3f;   // radians per step
  float shift = 5e-4f;  // metres per step, on a head of the template's size
  float last = 0.02f;   // of both, as a fraction of the first, at the end of the run
  float spread = 3;     // instants over which a step acts (AdvanceBust)
};

class BustTrack {
 public:
  BustTrack() = default;
  // poses: [instants] in the order of time, to begin with. instants: [frames] of each. Starts in
  // host memory.
  BustTrack(const AvatarPoser& poser,
            const std::vector<BustPose>& poses,
            std::vector<size_t> instants,
            const BustRates& rates,
            int iterations);

  bool empty() const { return instants_.empty(); }
  void WorkIn(Stream& stream);
  // Moves the bust, whose vertices are the last of [V, 3] in the stream's memory.
  void PoseBust(size_t frame, View<float> vertices);
  // One Adam step on the pose at a frame's instant. first_face: of the bust's. If *overflowed is
  // not 0, nothing changes.
  void Advance(size_t frame,
               const Embedding& embedding,
               size_t first_face,
               const PosedGaussians& posed,
               const PosedGaussians& d_posed,
               const uint32_t* overflowed);

  BustPose PoseOf(size_t frame) const;
  // [instants] with the first frame of each; in host memory.
  std::vector<BustPose> Poses() const;
  const std::vector<size_t>& first_frames() const { return first_frames_; }
  // The complete state, in host memory.
  std::vector<BustState> States() const;
  void SetStates(const std::vector<BustState>& states);
  size_t allocated_bytes() const { return AllocatedBytes(states_, mean_, sums_); }

 private:
  Stream* stream_ = &HostStream();
  std::vector<size_t> instants_, first_frames_;
  std::vector<float> mean_on_host_;
  math::Vec3<float> pivot_{0, 0, 0};
  BustRates rates_;
  float decay_ = 1;
  Buffer<BustState> states_;
  Buffer<float> mean_;
  Buffer<double> sums_;
};

// Numbers the frames' instants, in the order of time; frames of several cameras share one.
std::vector<size_t> InstantsOf(const std::vector<int>& timesteps);

// The shift of the bust in each frame, in metres, with which its image below the neck agrees best
// with that of the frame in the middle, compared from coarse to fine. Not more than a start: it
// knows no turns. Frames need masks. vertices: [frames] of [V, 3], the bust at its mean place.
std::vector<BustPose> RegisterBusts(const AvatarPoser& poser,
                                    const std::vector<TrainFrame>& frames,
                                    const std::vector<std::vector<float>>& vertices);

}  // namespace cosplat
