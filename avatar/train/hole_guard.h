// Keeps removals from tearing holes into an avatar.
//
// marks -> Begin (whose triangle is left with none) -> Spare, frame after frame, which draws with
// and without what is to go and takes back the marks of those that are drawn near a hole.
#pragma once

#include "avatar/surface/binding.h"
#include "splat/train/density.h"

namespace cosplat {

class HoleGuard {
 public:
  // unwanted: [N] 1: goes. Whether there is a triangle that would be left with no Gaussian; waits.
  bool Begin(const Gaussians& gaussians,
             FaceListArrays by_face,
             size_t face_count,
             View<const uint8_t> unwanted,
             Stream& stream);
  // world: of all Gaussians, as they were at Begin; silhouette: [height, width] of the mesh, in the
  // stream's memory.
  void Spare(const Canvas& canvas,
             const WorldGaussians& world,
             Basis basis,
             const Camera& camera,
             const Buffer<uint8_t>& silhouette,
             View<uint8_t> unwanted);
  // Bytes that grow with the Gaussians, and with pixels.
  size_t held() const { return HeldBy(last_, logits_); }
  size_t HeldForPixels() const { return HeldBy(holes_, after_); }
  static constexpr size_t kBytesPerGaussian = sizeof(uint8_t) + sizeof(float);

 private:
  Buffer<uint8_t> last_;   // [N] 1: the last of its triangle that would go
  Buffer<uint64_t> any_;   // [F + 1] whether a face has some
  Buffer<float> logits_;   // [N] opacities without those that are to go
  Buffer<uint8_t> holes_;  // [height, width]
  Buffer<float> after_;    // [height, width] transmittance without them
};

}  // namespace cosplat
