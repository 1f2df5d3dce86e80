#include "apps/study/avatar_stability/naive_walk.h"

#include <array>

#include "avatar/math/released.h"

namespace cosplat {
namespace {

using Weights = std::array<double, 3>;

// Whether the system of the path and the lines of the three edges is singular.
bool IsParallelToAnEdge(const Weights& step) { return step[0] * step[1] * step[2] == 0; }

// The corner whose weight reaches zero first, and the share of the step until then; -1 if there is
// none because the weights are NaN.
int NaiveExit(const Weights& at, const Weights& step, double& share) {
  int corner = -1;
  share = 1;
  for (int i = 0; i < 3; ++i) {
    const double meets = at[i] / -step[i];
    if (!(step[i] < 0) || !(meets < share)) continue;
    share = meets;
    corner = i;
  }
  return corner;
}

bool IsInside(const Weights& at, const Weights& step) {
  return at[0] + step[0] >= 0 && at[1] + step[1] >= 0 && at[2] + step[2] >= 0;
}

}  // namespace

NaiveWalkResult WalkNaively(
    const Surface& surface, const SurfacePoint& start, float du, float dv, int max_rounds) {
  const MeshTopology& topology = surface.topology();
  int32_t face = start.triangle;
  const double u = start.barycentric[0], v = start.barycentric[1];
  Weights at{u, v, 1 - u - v}, step{du, dv, -double(du) - double(dv)};
  const auto result = [&](const Weights& w, bool ended) {
    return NaiveWalkResult{{face, {float(w[0]), float(w[1])}}, ended};
  };
  for (int round = 0; round < max_rounds; ++round) {
    if (IsInside(at, step)) return result({at[0] + step[0], at[1] + step[1], 0}, true);
    if (IsParallelToAnEdge(step)) return result(at, true);
    double share;
    const int corner = NaiveExit(at, step, share);
    if (corner < 0) continue;
    const int edge = (corner + 1) % 3, end = (edge + 1) % 3;
    for (int i = 0; i < 3; ++i) {
      at[i] += share * step[i];
      step[i] *= 1 - share;
    }
    at[corner] = 0;
    const int32_t next = topology.face_neighbors[face][edge];
    if (next < 0) return result(at, true);
    math::ParallelogramCrossing(step[edge], step[end], step[corner]);
    const int entry = topology.neighbor_edges[face][edge];
    Weights at_next{}, step_next{};
    at_next[entry] = at[end];
    at_next[(entry + 1) % 3] = at[edge];
    step_next[entry] = step[end];
    step_next[(entry + 1) % 3] = step[edge];
    step_next[(entry + 2) % 3] = step[corner];
    face = next;
    at = at_next;
    step = step_next;
  }
  return result(at, false);
}

}  // namespace cosplat
