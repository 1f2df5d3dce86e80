// Walking on triangles on the device: WalkAll (avatar/surface/walk.h) there, by the same body.
//
// A thread walks a Gaussian. Who may stay on a face with a boundary edge depends on those that come
// before it, so one thread takes the walks that touch such a face in turn: some in a hundred.
#pragma once

#include "avatar/surface/cuda/device_binding.h"
#include "avatar/surface/cuda/device_mesh.h"
#include "avatar/surface/kernels/walk.h"
#include "splat/device/cuda/sort.h"
#include "splat/device/memory_part.h"

namespace cosplat::cuda {

class DeviceWalk {
 public:
  // What WalkReport says of a Gaussian.
  enum Outcome : uint8_t { kCrossed = 1, kStopped = 2, kInvalid = 4 };

  // As WalkAll. position: kPosition of the Gaussians.
  void Walk(const DeviceMesh& mesh,
            int boundary_face_cap,
            DeviceEmbedding& embedding,
            DeviceBuffer<float>& position,
            cudaStream_t stream);
  // Zeroes what a moment of kPosition has for du and dv that have lost their meaning in the walk.
  void ResetMoment(DeviceBuffer<float>& moment, cudaStream_t stream) const;

  // [N] of the last walk.
  const DeviceBuffer<uint8_t>& outcomes() const { return outcomes_; }
  // Bytes that grow with the Gaussians, and others.
  size_t held() const;
  size_t HeldForMesh() const { return HeldBy(face_count_); }
  // Each Gaussian's.
  static constexpr size_t kBytesPerGaussian =
      sizeof(math::WalkEnd) + 2 * sizeof(uint8_t) + sizeof(uint64_t) + sizeof(uint32_t);

 private:
  void TakeInTurn(const DeviceMesh& mesh,
                  int boundary_face_cap,
                  DeviceEmbedding& embedding,
                  cudaStream_t stream);

  DeviceBuffer<math::WalkEnd> ends_;        // [N]
  DeviceBuffer<uint8_t> taken_, outcomes_;  // [N]
  DeviceBuffer<uint64_t> places_;           // [N + 1] of walks that touch a boundary's face
  DeviceBuffer<uint32_t> at_boundary_;      // [N] they come first, ascending
  DeviceBuffer<int32_t> face_count_;        // [F]
  Sorter sorter_;
};

}  // namespace cosplat::cuda
