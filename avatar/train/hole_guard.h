// Keeps pruning from opening holes in an avatar.
//
// marks of unwanted Gaussians -> Begin (finds triangles that would lose all Gaussians) -> Spare,
// once per frame, which renders with and without the unwanted Gaussians and clears the marks of
// those near a hole.
#pragma once

#include "avatar/surface/binding.h"
#include "splat/train/density/density.h"

namespace cosplat {

class HoleGuard {
 public:
  // unwanted: [N] 1: to be removed. Returns whether any triangle would be left without Gaussians;
  // waits for the stream.
  bool Begin(const Gaussians& gaussians,
             FaceListArrays by_face,
             size_t face_count,
             View<const uint8_t> unwanted,
             Stream& stream);
  // world: all Gaussians, unchanged since Begin. silhouette: [height, width] of the mesh, in the
  // stream's memory.
  void Spare(const Canvas& canvas,
             const WorldGaussians& world,
             Basis basis,
             const Camera& camera,
             const Buffer<uint8_t>& silhouette,
             View<uint8_t> unwanted);
  // Bytes of buffers per Gaussian, and of buffers per pixel.
  size_t allocated_bytes() const { return AllocatedBytes(last_, logits_); }
  size_t PixelBytes() const { return AllocatedBytes(holes_, after_); }
  static constexpr size_t kBytesPerGaussian = sizeof(uint8_t) + sizeof(float);

 private:
  Buffer<uint8_t> last_;   // [N] 1: its triangle would be left without Gaussians
  Buffer<uint64_t> any_;   // [F + 1] whether a face would be; then the prefix sum
  Buffer<float> logits_;   // [N] opacity logits, with unwanted Gaussians made invisible
  Buffer<uint8_t> holes_;  // [height, width]
  Buffer<float> after_;    // [height, width] transmittance without the unwanted Gaussians
};

}  // namespace cosplat
