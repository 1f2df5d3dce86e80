// Walking on triangles: the step (du, dv) of an embedded Gaussian is followed over the canonical
// mesh, straight across edges, and becomes its new triangle and barycentrics.
//
// At regular intervals in training: AvatarModel -> WalkAll -> the same Gaussians with du = dv = 0.
// "Walking on triangles" is from Shao et al. 2024 (SplattingAvatar), section 3.2, after Phong
// surfaces (Shen et al. 2020). This implementation unfolds the next triangle about the shared edge
// with its true lengths (Mitchell, Mount & Papadimitriou 1987), so that a straight step stays
// straight.
//
// At a boundary of the mesh the step loses its component across the boundary and continues along
// it; it ends at a second boundary. Every end point keeps all its weights at least a millionth
// (kInsideTriangle). Faces with zero canonical area act as boundaries as well.
#pragma once

#include <cstdint>
#include <vector>

#include "avatar/model/avatar_model.h"
#include "avatar/surface/binding.h"
#include "avatar/surface/kernels/walk.h"

namespace cosplat {

struct WalkResult {
  SurfacePoint point;
  WalkStatus status = WalkStatus::kWithin;
};

// Moves `start` by du, dv (changes of its barycentrics u, v) over the canonical mesh.
WalkResult Walk(const Surface& surface, const SurfacePoint& start, float du, float dv);

// Indices of Gaussians, ascending. The Adam moments of du and dv of the Gaussians in any of the
// lists are no longer valid and must be zeroed.
struct WalkReport {
  std::vector<uint32_t> crossed;              // now on another triangle
  std::vector<uint32_t> stopped_at_boundary;  // may be in `crossed` as well
  std::vector<uint32_t> invalid;              // not moved
};

// The number of Gaussians on a face with a boundary edge above which no more may walk onto it.
constexpr int kBoundaryFaceCap = 64;

// Walks Gaussians on the host or on a device, in the memory of the surface's stream. Reuse the
// object to avoid allocations.
class TriangleWalk {
 public:
  // Walks every Gaussian with nonzero du or dv and sets these to zero. position: kPosition. A
  // Gaussian whose walk would end on another face that has a boundary edge and already has
  // `boundary_face_cap` Gaussians is not moved and counts as stopped, so that a steady gradient
  // does not pile Gaussians up at the mouth or the neck. The triangles must exist.
  void Run(const Surface& surface,
           int boundary_face_cap,
           FaceLists& by_face,
           Embedding& embedding,
           Buffer<float>& position);
  // Zeroes an Adam moment of kPosition for du and dv where the last walk made it invalid.
  void ResetMoment(Buffer<float>& moment, Stream& stream) const;

  const Buffer<uint8_t>& outcomes() const { return outcomes_; }  // [N] WalkOutcome of the last walk
  // Bytes of buffers per Gaussian, and of buffers per face.
  size_t allocated_bytes() const {
    return AllocatedBytes(ends_, taken_, outcomes_, places_, at_boundary_);
  }
  size_t MeshBytes() const { return AllocatedBytes(face_count_); }
  static constexpr size_t kBytesPerGaussian =
      sizeof(math::WalkEnd) + 2 * sizeof(uint8_t) + sizeof(uint64_t) + sizeof(uint32_t);

 private:
  void TakeInTurn(const Surface& surface,
                  int boundary_face_cap,
                  FaceLists& by_face,
                  const Embedding& embedding);

  Buffer<math::WalkEnd> ends_;        // [N]
  Buffer<uint8_t> taken_, outcomes_;  // [N]
  Buffer<uint64_t> places_;           // [N + 1] prefix sum over walks that touch a boundary face
  Buffer<uint32_t> at_boundary_;      // [N] begins with their indices, ascending
  Buffer<int32_t> face_count_;        // [F]
};

// The same on the host, reporting lists of indices. Throws Error when a triangle does not exist.
WalkReport WalkAll(Gaussians& gaussians,
                   Embedding& embedding,
                   const Surface& surface,
                   int boundary_face_cap = kBoundaryFaceCap);
inline WalkReport WalkAll(AvatarModel& model,
                          const Surface& surface,
                          int boundary_face_cap = kBoundaryFaceCap) {
  return WalkAll(model.gaussians, model.embedding, surface, boundary_face_cap);
}

}  // namespace cosplat
