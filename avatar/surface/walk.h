// Walking on triangles: the step (du, dv) of an embedded Gaussian is followed over the canonical
// mesh, straight across edges, and becomes its new triangle and barycentrics.
//
// every so often in training: AvatarModel -> WalkAll -> the same Gaussians with du = dv = 0.
// "Walking on triangles" is Shao et al. 2024 (SplattingAvatar), section 3.2, after Phong surfaces
// (Shen et al. 2020). Ours unfolds the next triangle about the shared edge with its true lengths
// (Mitchell, Mount & Papadimitriou 1987), so that a straight step stays straight.
//
// At a boundary of the mesh the step loses its part across the boundary and goes on along it; where
// a second boundary stops that, it ends. Every point ends a millionth of its triangle inside it at
// least (kInsideTriangle). Faces with no canonical area are walls as well.
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

// Indices of Gaussians, ascending. du and dv of a Gaussian in any of the lists lose their meaning:
// their Adam moments are to be zeroed.
struct WalkReport {
  std::vector<uint32_t> crossed;              // now on another triangle
  std::vector<uint32_t> stopped_at_boundary;  // may be among the crossed as well
  std::vector<uint32_t> invalid;              // left where they were
};

// Of Gaussians on a face with a boundary edge, beyond which none walks onto it.
constexpr int kBoundaryFaceCap = 64;

// Walks Gaussians on the host or on a device, in the memory of the surface's stream. Reuse one: it
// keeps its memory.
class TriangleWalk {
 public:
  // Walks every Gaussian with du or dv (`position`: kPosition) other than zero and sets those to
  // zero. A Gaussian whose walk would end in another face that has a boundary edge and already
  // holds `boundary_face_cap` of them stays where it was (and counts as stopped): a steady push
  // does not pile them up at the mouth or the neck. The triangles must exist.
  void Run(const Surface& surface,
           int boundary_face_cap,
           FaceLists& by_face,
           Embedding& embedding,
           Buffer<float>& position);
  // Zeroes what a moment of kPosition has for du and dv that have lost their meaning in the walk.
  void ResetMoment(Buffer<float>& moment, Stream& stream) const;

  const Buffer<uint8_t>& outcomes() const { return outcomes_; }  // [N] WalkOutcome of the last walk
  // Bytes that grow with the Gaussians, and others.
  size_t held() const { return HeldBy(ends_, taken_, outcomes_, places_, at_boundary_); }
  size_t HeldForMesh() const { return HeldBy(face_count_); }
  static constexpr size_t kBytesPerGaussian =
      sizeof(math::WalkEnd) + 2 * sizeof(uint8_t) + sizeof(uint64_t) + sizeof(uint32_t);

 private:
  void TakeInTurn(const Surface& surface,
                  int boundary_face_cap,
                  FaceLists& by_face,
                  const Embedding& embedding);

  Buffer<math::WalkEnd> ends_;        // [N]
  Buffer<uint8_t> taken_, outcomes_;  // [N]
  Buffer<uint64_t> places_;           // [N + 1] of walks that touch a boundary's face
  Buffer<uint32_t> at_boundary_;      // [N] they come first, ascending
  Buffer<int32_t> face_count_;        // [F]
};

// The same on the host, said in lists. Throws Error when a triangle does not exist.
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
