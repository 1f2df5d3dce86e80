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
#include "avatar/surface/surface.h"

namespace cosplat {

enum class WalkStatus {
  kWithin,    // ended in the triangle it began in
  kCrossed,   // ended in another one
  kBoundary,  // met a boundary on its way; may have crossed edges too
  kInvalid    // not finite, or longer than kMaxWalkCrossings triangles: the point is left where it
              // was
};

struct WalkResult {
  SurfacePoint point;
  WalkStatus status = WalkStatus::kWithin;
};

// A step between two walks is a few triangles long; this many is a quarter of the way round FLAME's
// finely divided eyeballs.
constexpr int kMaxWalkCrossings = 256;

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

// Walks every Gaussian with du or dv other than zero and sets those to zero. A Gaussian whose walk
// would end in another face that has a boundary edge and already holds `boundary_face_cap` of them
// stays where it was (and counts as stopped): a steady push does not pile them up at the mouth or
// the neck. Throws Error when a triangle does not exist.
WalkReport WalkAll(Gaussians& gaussians,
                   Embedding& embedding,
                   const Surface& surface,
                   int boundary_face_cap = kBoundaryFaceCap);
inline WalkReport WalkAll(AvatarModel& model,
                          const Surface& surface,
                          int boundary_face_cap = kBoundaryFaceCap) {
  return WalkAll(model.gaussians, model, surface, boundary_face_cap);
}

}  // namespace cosplat
