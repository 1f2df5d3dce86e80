#include "avatar/embed_packs.h"

#include <algorithm>
#include <cmath>

#include "avatar/parallel_for.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "avatar/embed_packs.cpp"
#include <hwy/foreach_target.h>  // IWYU pragma: keep
#include <hwy/highway.h>

#include "avatar/gather_rows.h"
#include "avatar/math/embed.h"

COSPLAT_MATH_BEGIN

// What Embed takes, a Gaussian per lane.
struct EmbedInput {
  Three<SurfaceVertex<Pack>> vertices;
  Three<Pack> canonical_area;
  LocalGaussian<Pack> local;
};

HWY_INLINE EmbedInput LoadEmbedInput(const EmbedJob& job, const Rows& rows) {
  EmbedInput in;
  const LaneRows faces = RowPerLane(rows, [&](size_t i) { return job.triangle[i]; });
  for (int c = 0; c < 3; ++c) {
    LaneRows corner;
    for (size_t l = 0; l < kLanes; ++l) corner[l] = job.faces[faces[l]][c];
    Pack v[kSurfaceVertexFloats];
    GatherRows<kSurfaceVertexFloats>(job.vertices, kSurfaceVertexFloats, corner, v);
    in.vertices[c] = {{v[0], v[1], v[2]}, {v[3], v[4], v[5]}, {v[6], v[7], v[8], v[9]}, v[10]};
  }
  Pack area[4];
  GatherRows<4>(job.canonical_areas, 4, faces, area);
  in.canonical_area = {{area[0], area[1], area[2]}};
  Pack base[2];
  LoadRows<2>(job.barycentric->data(), 2, rows, base);
  in.local = {base[0],
              base[1],
              LoadVec3<Pack>(job.offset, rows),
              LoadQuat<Pack>(job.rotation, rows),
              LoadVec3<Pack>(job.scale_log, rows)};
  return in;
}

HWY_INLINE void StoreVec3(const Vec3<Pack>& v, float* array, const Rows& rows) {
  const Pack row[3] = {v.x, v.y, v.z};
  StoreRows<3>(row, array, 3, rows);
}
HWY_INLINE void StoreQuat(const Quat<Pack>& q, float* array, const Rows& rows) {
  const Pack row[4] = {q.w, q.x, q.y, q.z};
  StoreRows<4>(row, array, 4, rows);
}

void EmbedRange(const EmbedJob& job, const PosedArrays<float>& out, size_t begin, size_t end) {
  for (size_t i = begin; i < end; i += kLanes) {
    const Rows rows{i, std::min(kLanes, end - i)};
    const EmbedInput in = LoadEmbedInput(job, rows);
    const PosedGaussian<Pack> posed = Embed(in.vertices, in.canonical_area, in.local);
    StoreVec3(posed.position, out.position, rows);
    StoreQuat(posed.rotation, out.rotation, rows);
    StoreVec3(posed.scale_log, out.scale_log, rows);
    StoreQuat(posed.frame, out.frame, rows);
  }
}

HWY_INLINE void StoreCorners(const Three<SurfaceVertex<Pack>>& d, float* array, const Rows& rows) {
  for (int c = 0; c < 3; ++c) {
    const SurfaceVertex<Pack>& v = d[c];
    const Pack row[kSurfaceVertexFloats] = {v.position.x,
                                            v.position.y,
                                            v.position.z,
                                            v.normal.x,
                                            v.normal.y,
                                            v.normal.z,
                                            v.rotation.w,
                                            v.rotation.x,
                                            v.rotation.y,
                                            v.rotation.z,
                                            v.area};
    StoreRows<kSurfaceVertexFloats>(
        row, array + c * kSurfaceVertexFloats, 3 * kSurfaceVertexFloats, rows);
  }
}

void EmbedVjpRange(const EmbedJob& job,
                   const PosedArrays<const float>& d_posed,
                   const EmbedAdjoints& out,
                   size_t begin,
                   size_t end) {
  const Pack zero(0.0f);
  for (size_t i = begin; i < end; i += kLanes) {
    const Rows rows{i, std::min(kLanes, end - i)};
    const EmbedInput in = LoadEmbedInput(job, rows);
    PosedGaussian<Pack> d{LoadVec3<Pack>(d_posed.position, rows),
                          LoadQuat<Pack>(d_posed.rotation, rows),
                          LoadVec3<Pack>(d_posed.scale_log, rows),
                          {zero, zero, zero, zero}};
    if (d_posed.frame) d.frame = LoadQuat<Pack>(d_posed.frame, rows);
    LocalGaussian<Pack> d_local;
    Three<SurfaceVertex<Pack>> d_corners;
    for (int c = 0; c < 3; ++c)
      d_corners[c] = {{zero, zero, zero}, {zero, zero, zero}, {zero, zero, zero, zero}, zero};
    EmbedVjp(
        in.vertices, in.canonical_area, in.local, d, d_local, out.corners ? &d_corners : nullptr);
    StoreVec3(d_local.offset, out.offset, rows);
    StoreQuat(d_local.rotation, out.rotation, rows);
    StoreVec3(d_local.scale_log, out.scale_log, rows);
    if (out.corners) StoreCorners(d_corners, out.corners, rows);
  }
}

COSPLAT_MATH_END

#if HWY_ONCE
namespace cosplat {
namespace math {
HWY_EXPORT(EmbedRange);
HWY_EXPORT(EmbedVjpRange);
}  // namespace math

namespace {
constexpr size_t kGrain = 512;  // a multiple of every pack's lanes
}  // namespace

void LaunchEmbed(const EmbedJob& job, const PosedArrays<float>& out) {
  using namespace math;
  ParallelForRanges(job.count, kGrain, [&](size_t begin, size_t end) {
    HWY_DYNAMIC_DISPATCH(EmbedRange)(job, out, begin, end);
  });
}

void LaunchEmbedVjp(const EmbedJob& job,
                    const PosedArrays<const float>& d_posed,
                    const EmbedAdjoints& out) {
  using namespace math;
  ParallelForRanges(job.count, kGrain, [&](size_t begin, size_t end) {
    HWY_DYNAMIC_DISPATCH(EmbedVjpRange)(job, d_posed, out, begin, end);
  });
}

}  // namespace cosplat
#endif
