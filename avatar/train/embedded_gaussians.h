// Where the Gaussians of a training are on the mesh, in the memory of a stream.
//
// SampleSurface -> EmbeddedGaussians: BindBackward's scratch, walks, density control -> embedding
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "avatar/model/avatar_model.h"
#include "avatar/surface/binding.h"
#include "avatar/surface/kernels/face_search.h"
#include "avatar/surface/surface.h"
#include "avatar/surface/walk.h"
#include "splat/train/state/training_state.h"

namespace cosplat {

class EmbeddedGaussians {
 public:
  EmbeddedGaussians() = default;
  // embedding, first_triangle ([N] on which each Gaussian, or its first ancestor, began),
  // face_rates ([F] factors on the learning rates of du and dv on each face): in host memory.
  EmbeddedGaussians(const Embedding& embedding,
                    const Buffer<int32_t>& first_triangle,
                    const std::vector<float>& face_rates,
                    Stream& stream);

  const Embedding& embedding() const { return embedding_; }
  // BindBackward's memory, which keeps the lists of each face's Gaussians until they change.
  BindScratch& scratch() { return scratch_; }
  // [N, 3] factors on the learning rates of (du, dv, d).
  View<const float> RateScale();
  // Copies to host memory.
  Embedding EmbeddingOnHost() const;
  Buffer<int32_t> FirstTriangles() const {
    return Buffer<int32_t>(first_triangle_.Downloaded(*stream_));
  }
  std::vector<int32_t> Triangles() const { return embedding_.triangle.Downloaded(*stream_); }

  // Walks over the mesh by (du, dv), and zeroes the moments that a walk makes invalid.
  void Walk(const Surface& surface, Gaussians& gaussians, AdamState& adam);
  // Density control: see Placement (splat/train/subject/placement.h). `released`: children are
  // placed by the rule of SplattingAvatar's code release.
  void Gather(View<const uint32_t> source);
  View<const float> Centers(const Surface& surface, const Gaussians& gaussians);
  void Move(const Surface& surface,
            bool released,
            View<const float> offsets,
            size_t first,
            Gaussians& gaussians);

  // Bytes of buffers per Gaussian, and of buffers per face.
  size_t allocated_bytes() const;
  size_t MeshBytes() const;
  static constexpr size_t kBytesPerGaussian =
      2 * (sizeof(int32_t) + 2 * sizeof(float)) + sizeof(int32_t) + 6 * sizeof(float) +
      FaceLists::kBytesPerGaussian + TriangleWalk::kBytesPerGaussian;

 private:
  void TrianglesChanged();

  Stream* stream_ = &HostStream();
  Embedding embedding_;
  Buffer<int32_t> first_triangle_;  // [N]
  Buffer<float> face_rates_;        // [F]
  BindScratch scratch_;
  TriangleWalk walk_;
  Buffer<math::FaceSearch> searches_;
  Buffer<float> centers_;
  Buffer<float> rate_scale_;  // [N, 3]
  bool rates_known_ = false;
  Buffer<int32_t> spare_triangle_;
  Buffer<std::array<float, 2>> spare_barycentric_;
};

}  // namespace cosplat
