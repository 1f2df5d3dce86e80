#include "avatar/surface_packs.h"

#include <algorithm>
#include <cmath>

#include "avatar/parallel_for.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "avatar/surface_packs.cpp"
#include <hwy/foreach_target.h>  // IWYU pragma: keep
#include <hwy/highway.h>

#include "avatar/gather_rows.h"
#include "avatar/math/frame.h"

COSPLAT_MATH_BEGIN

struct FaceCorners {
  Vec3<Pack> p[3];
};

HWY_INLINE FaceCorners LoadCorners(const SurfaceArrays& s, const Rows& rows) {
  FaceCorners corners;
  for (int c = 0; c < 3; ++c) {
    Pack row[4];  // the position and a number that is not used
    const LaneRows vertices = RowPerLane(rows, [&](size_t f) { return s.faces[f][c]; });
    GatherRows<4>(s.vertices, kSurfaceVertexFloats, vertices, row);
    corners.p[c] = {row[0], row[1], row[2]};
  }
  return corners;
}

void PoseFaces(const SurfaceArrays& s, size_t begin, size_t end) {
  for (size_t i = begin; i < end; i += kLanes) {
    const Rows rows{i, std::min(kLanes, end - i)};
    const FaceCorners at = LoadCorners(s, rows);
    Mat3<Pack> canonical;
    LoadRows<9>(s.canonical_frames, 9, rows, canonical.m);
    const Vec3<Pack> area = AreaVector(at.p[0], at.p[1], at.p[2]);
    const Quat<Pack> q = FaceRotation(at.p[0], at.p[1], at.p[2], canonical);
    const Pack row[kPosedFaceFloats] = {area.x, area.y, area.z, Length(area), q.w, q.x, q.y, q.z};
    StoreRows<kPosedFaceFloats>(row, s.posed_faces, kPosedFaceFloats, rows);
  }
}

// The faces around the vertices of a pack.
struct Fans {
  std::array<int32_t, kLanes> begin, count;
  int32_t longest = 0;

  Fans(const SurfaceArrays& s, const Rows& rows) {
    begin = RowPerLane(rows, [&](size_t v) { return s.vertex_face_begin[v]; });
    const LaneRows last = RowPerLane(rows, [&](size_t v) { return s.vertex_face_begin[v + 1]; });
    for (size_t l = 0; l < kLanes; ++l) {
      count[l] = last[l] - begin[l];
      longest = std::max(longest, count[l]);
    }
  }
  HWY_INLINE Pack Counts() const {
    alignas(64) float lane[kLanes];
    for (size_t l = 0; l < kLanes; ++l) lane[l] = float(count[l]);
    return LoadPack(lane);
  }
};

struct VertexSums {
  Vec3<Pack> normal;
  Quat<Pack> rotation;
  Pack area;
};

// Each rotation is added in the hemisphere of the sum so far, which therefore only grows: face
// rotations cannot cancel at a vertex.
HWY_INLINE VertexSums SumFaces(const SurfaceArrays& s, const Fans& fans, const Rows& rows) {
  const Pack zero(0.0f);
  VertexSums sum{{zero, zero, zero}, {zero, zero, zero, zero}, zero};
  for (int32_t k = 0; k < fans.longest; ++k) {
    LaneRows faces;
    for (size_t l = 0; l < kLanes; ++l)
      faces[l] = k < fans.count[l] ? s.vertex_faces[fans.begin[l] + k] : int32_t(s.face_count);
    Pack face[kPosedFaceFloats];
    GatherRows<kPosedFaceFloats>(s.posed_faces, kPosedFaceFloats, faces, face);
    const Quat<Pack> q{face[4], face[5], face[6], face[7]};
    const Pack sign = HemisphereSign(sum.rotation, q);
    sum.normal += Vec3<Pack>{face[0], face[1], face[2]};
    sum.rotation = sum.rotation + q * (sign * face[3]);
    sum.area += face[3];
    alignas(64) float signs[kLanes];
    StorePack(sign, signs);
    for (size_t l = 0; l < rows.count; ++l)
      if (k < fans.count[l]) s.signs[fans.begin[l] + k] = signs[l];
  }
  return sum;
}

void PoseVertices(const SurfaceArrays& s, size_t begin, size_t end) {
  const Pack one(1.0f);
  for (size_t i = begin; i < end; i += kLanes) {
    const Rows rows{i, std::min(kLanes, end - i)};
    const Fans fans(s, rows);
    const VertexSums sum = SumFaces(s, fans, rows);
    // Areas of a head in metres are near 1e-5: the sum is brought to norm 1 or less before
    // Normalize's floor, which is meant for quaternions of order 1, sees it.
    const auto some = sum.area > Pack(0.0f);
    const Quat<Pack> r = sum.rotation * (one / Select(some, sum.area, one));
    const Pack sums[kVertexSumFloats] = {
        sum.normal.x, sum.normal.y, sum.normal.z, r.w, r.x, r.y, r.z};
    StoreRows<kVertexSumFloats>(sums, s.sums, kVertexSumFloats, rows);
    const Vec3<Pack> n = Normalize(sum.normal);
    const Quat<Pack> q = Normalize(r);
    const Pack area = sum.area / Max(fans.Counts(), one);
    const Pack row[8] = {n.x, n.y, n.z, q.w, q.x, q.y, q.z, area};
    StoreRows<8>(row, s.vertices + 3, kSurfaceVertexFloats, rows);
  }
}

// To the sums over the faces: of the normals, of the rotations before their division by the area
// (which changes the sum's norm only, and that Normalize ignores: the area may be taken as a
// constant there), and of the areas.
void VerticesVjp(
    const SurfaceArrays& s, const float* d_vertices, float* d_sums, size_t begin, size_t end) {
  const Pack zero(0.0f), one(1.0f);
  for (size_t i = begin; i < end; i += kLanes) {
    const Rows rows{i, std::min(kLanes, end - i)};
    Pack d[kSurfaceVertexFloats], sum[kVertexSumFloats], mean_area[1];
    LoadRows<kSurfaceVertexFloats>(d_vertices, kSurfaceVertexFloats, rows, d);
    LoadRows<kVertexSumFloats>(s.sums, kVertexSumFloats, rows, sum);
    LoadRows<1>(s.vertices + kSurfaceVertexFloats - 1, kSurfaceVertexFloats, rows, mean_area);
    const Pack count = Max(Fans(s, rows).Counts(), one);
    const Pack area = mean_area[0] * count;
    const auto some = area > zero;
    const Vec3<Pack> n =
        NormalizeVjp(Vec3<Pack>{sum[0], sum[1], sum[2]}, Vec3<Pack>{d[3], d[4], d[5]});
    const Quat<Pack> q = NormalizeVjp(Quat<Pack>{sum[3], sum[4], sum[5], sum[6]},
                                      Quat<Pack>{d[6], d[7], d[8], d[9]}) *
                         Select(some, one / Select(some, area, one), zero);
    const Pack row[kSurfaceVertexFloats] = {
        d[0], d[1], d[2], n.x, n.y, n.z, q.w, q.x, q.y, q.z, d[10] / count};
    StoreRows<kSurfaceVertexFloats>(row, d_sums, kSurfaceVertexFloats, rows);
  }
}

void FacesVjp(
    const SurfaceArrays& s, const float* d_sums, float* d_corners, size_t begin, size_t end) {
  const Pack zero(0.0f);
  for (size_t i = begin; i < end; i += kLanes) {
    const Rows rows{i, std::min(kLanes, end - i)};
    const FaceCorners at = LoadCorners(s, rows);
    Mat3<Pack> canonical;
    LoadRows<9>(s.canonical_frames, 9, rows, canonical.m);
    Pack face[kPosedFaceFloats];
    LoadRows<kPosedFaceFloats>(s.posed_faces, kPosedFaceFloats, rows, face);
    const Quat<Pack> rotation{face[4], face[5], face[6], face[7]};
    Vec3<Pack> d_vector{zero, zero, zero};
    Quat<Pack> d_rotation{zero, zero, zero, zero};
    Pack d_area = zero;
    for (int c = 0; c < 3; ++c) {
      Pack d[kSurfaceVertexFloats];
      const LaneRows vertices = RowPerLane(rows, [&](size_t f) { return s.faces[f][c]; });
      GatherRows<kSurfaceVertexFloats>(d_sums, kSurfaceVertexFloats, vertices, d);
      alignas(64) float signs[kLanes];
      for (size_t l = 0; l < kLanes; ++l)
        signs[l] = s.signs[s.corner_places[3 * (i + (l < rows.count ? l : 0)) + c]];
      const Pack sign = LoadPack(signs);
      const Quat<Pack> d_q{d[6], d[7], d[8], d[9]};
      d_vector += Vec3<Pack>{d[3], d[4], d[5]};
      d_rotation = d_rotation + d_q * (sign * face[3]);
      d_area += d[10] + sign * Dot(rotation, d_q);
    }
    d_vector += LengthVjp(Vec3<Pack>{face[0], face[1], face[2]}, d_area);
    Vec3<Pack> d[3];
    for (Vec3<Pack>& corner : d) corner = {zero, zero, zero};
    AreaVectorVjp(at.p[0], at.p[1], at.p[2], d_vector, d[0], d[1], d[2]);
    FaceRotationVjp(at.p[0], at.p[1], at.p[2], canonical, d_rotation, d[0], d[1], d[2]);
    const Pack row[9] = {d[0].x, d[0].y, d[0].z, d[1].x, d[1].y, d[1].z, d[2].x, d[2].y, d[2].z};
    StoreRows<9>(row, d_corners, 9, rows);
  }
}

COSPLAT_MATH_END

#if HWY_ONCE
namespace cosplat {
namespace math {
HWY_EXPORT(PoseFaces);
HWY_EXPORT(PoseVertices);
HWY_EXPORT(VerticesVjp);
HWY_EXPORT(FacesVjp);
}  // namespace math

namespace {
constexpr size_t kGrain = 512;  // a multiple of every pack's lanes
}  // namespace

void LaunchPoseSurface(const SurfaceArrays& s) {
  using namespace math;
  ParallelForRanges(s.face_count, kGrain, [&](size_t begin, size_t end) {
    HWY_DYNAMIC_DISPATCH(PoseFaces)(s, begin, end);
  });
  ParallelForRanges(s.vertex_count, kGrain, [&](size_t begin, size_t end) {
    HWY_DYNAMIC_DISPATCH(PoseVertices)(s, begin, end);
  });
}

void LaunchPoseSurfaceVjp(const SurfaceArrays& s,
                          const float* d_vertices,
                          float* d_sums,
                          float* d_corners) {
  using namespace math;
  ParallelForRanges(s.vertex_count, kGrain, [&](size_t begin, size_t end) {
    HWY_DYNAMIC_DISPATCH(VerticesVjp)(s, d_vertices, d_sums, begin, end);
  });
  ParallelForRanges(s.face_count, kGrain, [&](size_t begin, size_t end) {
    HWY_DYNAMIC_DISPATCH(FacesVjp)(s, d_sums, d_corners, begin, end);
  });
}

}  // namespace cosplat
#endif
