// Keeps removals on the device from tearing holes into an avatar: AvatarSubject::Veto
// (avatar/train/trainer.h) there, by the same bodies (avatar/surface/kernels/holes.h).
//
// marks -> Begin (whose triangle is left with none) -> Spare, frame after frame, which draws with
// and without what is to go and takes back the marks of those that are drawn near a hole.
#pragma once

#include "avatar/surface/cuda/device_binding.h"
#include "splat/train/cuda/device_subject.h"

namespace cosplat::cuda {

class HoleGuard {
 public:
  // unwanted: [N] 1: goes. Whether there is a triangle that would be left with no Gaussian; the
  // host waits.
  bool Begin(const DeviceGaussians& gaussians,
             DeviceEmbedding& embedding,
             DeviceView<const uint8_t> unwanted,
             cudaStream_t stream);
  // world: of all Gaussians, as they were at Begin; silhouette: [height, width] of the mesh.
  void Spare(const Canvas& canvas,
             const WorldGaussians& world,
             const Camera& camera,
             const DeviceBuffer<uint8_t>& silhouette,
             DeviceView<uint8_t> unwanted);
  // Bytes that grow with the Gaussians, and with pixels.
  size_t held() const { return HeldBy(last_, logits_); }
  size_t HeldForPixels() const { return HeldBy(holes_, after_); }
  // Each Gaussian's.
  static constexpr size_t kBytesPerGaussian = sizeof(uint8_t) + sizeof(float);

 private:
  DeviceBuffer<uint8_t> last_;   // [N] 1: the last of its triangle that would go
  DeviceBuffer<uint32_t> any_;   // [1] how many of those
  DeviceBuffer<float> logits_;   // [N] opacities without those that are to go
  DeviceBuffer<uint8_t> holes_;  // [height, width]
  DeviceBuffer<float> after_;    // [height, width] transmittance without them
  Readback<uint32_t> readback_;
};

}  // namespace cosplat::cuda
