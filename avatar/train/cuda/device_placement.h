// What follows from where Gaussians are on the canonical mesh, on the device: AvatarSubject's
// Center, Move, Gather and PositionRateScale (avatar/train/trainer.h) there, by the same bodies
// (avatar/surface/kernels/place.h).
#pragma once

#include "avatar/surface/cuda/device_binding.h"
#include "avatar/surface/cuda/device_mesh.h"
#include "avatar/surface/kernels/face_search.h"
#include "splat/device/memory_part.h"

namespace cosplat::cuda {

class DevicePlacement {
 public:
  // Takes the memory of searches, 13 MB: when there are children to place, there may be none left.
  DevicePlacement();

  // Moves all from `first` on by a row of `offsets` ([rows, 3]) each, and re-embeds them; keeps_d:
  // with the d that they had.
  void Move(const DeviceMesh& mesh,
            DeviceView<const float> offsets,
            size_t first,
            bool keeps_d,
            DeviceEmbedding& embedding,
            DeviceBuffer<float>& position,
            cudaStream_t stream);
  // [N, 3], until the next call.
  DeviceView<const float> Centers(const DeviceMesh& mesh,
                                  const DeviceEmbedding& embedding,
                                  const DeviceBuffer<float>& position,
                                  cudaStream_t stream);
  // rates: [N, 3] factors on the rates of kPosition. face_rates: [F] of du and dv.
  void Rates(DeviceView<const float> face_rates,
             const DeviceEmbedding& embedding,
             DeviceBuffer<float>& rates,
             cudaStream_t stream);
  // Entry i of `triangles` becomes what source[i] was.
  void GatherTriangles(DeviceView<const uint32_t> source,
                       DeviceBuffer<int32_t>& triangles,
                       cudaStream_t stream);
  // Bytes that grow with the Gaussians, and others.
  size_t held() const { return HeldBy(centers_, spare_); }
  size_t HeldForSearches() const { return HeldBy(searches_); }
  // Each Gaussian's.
  static constexpr size_t kBytesPerGaussian = 3 * sizeof(float) + sizeof(int32_t);

 private:
  DeviceBuffer<math::FaceSearch> searches_;  // of those that search at a time
  DeviceBuffer<float> centers_;
  DeviceBuffer<int32_t> spare_;
};

}  // namespace cosplat::cuda
