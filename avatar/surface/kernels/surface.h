// The posed surface and its derivative, element by element. The CPU runs these kernels on SIMD
// packs (avatar/surface/packs.cpp), a device with one thread per row
// (avatar/surface/cuda/kernels.cu).
//
// vertices' positions -> PoseFaces -> PoseVertices; backward: VerticesVjp -> FacesVjp -> SumCorners
// -> d_vertices. Formulas: avatar/math/frame.h.
#if defined(COSPLAT_AVATAR_KERNELS_SURFACE_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef COSPLAT_AVATAR_KERNELS_SURFACE_H_
#undef COSPLAT_AVATAR_KERNELS_SURFACE_H_
#else
#define COSPLAT_AVATAR_KERNELS_SURFACE_H_
#endif

#include "avatar/math/frame.h"
#include "avatar/surface/kernels/arrays.h"
#include "avatar/surface/kernels/gather.h"

COSPLAT_MATH_BEGIN

template <class T>
struct FaceCorners {
  Vec3<T> p[3];
};
template <class T>
COSPLAT_HD_FORCED LaneRows<T> CornerVertices(const SurfaceArrays& s, const Rows& rows, int corner) {
  return RowPerLane<T>(rows, [&](size_t f) { return s.faces[3 * f + size_t(corner)]; });
}
template <class T>
COSPLAT_HD_FORCED FaceCorners<T> LoadCorners(const SurfaceArrays& s, const Rows& rows) {
  FaceCorners<T> corners;
  for (int c = 0; c < 3; ++c) {
    T row[4];  // the position and an unused number
    GatherRows<4>(s.vertices, kSurfaceVertexFloats, CornerVertices<T>(s, rows, c), row);
    corners.p[c] = {row[0], row[1], row[2]};
  }
  return corners;
}

// One row per face: writes posed_faces.
template <class T>
COSPLAT_HD_FORCED void Run(const PoseFacesKernel& kernel, const Rows& rows) {
  const SurfaceArrays& s = kernel.s;
  const FaceCorners<T> at = LoadCorners<T>(s, rows);
  Mat3<T> canonical;
  LoadRows<9>(s.canonical_frames, 9, rows, canonical.m);
  const Vec3<T> area = AreaVector(at.p[0], at.p[1], at.p[2]);
  const Quat<T> q = FaceRotation(at.p[0], at.p[1], at.p[2], canonical);
  const T row[kPosedFaceFloats] = {area.x, area.y, area.z, Length(area), q.w, q.x, q.y, q.z};
  StoreRows<kPosedFaceFloats>(row, s.posed_faces, kPosedFaceFloats, rows);
}

// The faces around the vertex of each lane.
template <class T>
struct Fans {
  LaneRows<T> begin, count;
  int32_t longest = 0;

  COSPLAT_HD Fans(const SurfaceArrays& s, const Rows& rows) {
    begin = RowPerLane<T>(rows, [&](size_t v) { return s.vertex_face_begin[v]; });
    const LaneRows<T> last =
        RowPerLane<T>(rows, [&](size_t v) { return s.vertex_face_begin[v + 1]; });
    for (size_t l = 0; l < kLaneCount<T>; ++l) {
      count[l] = last[l] - begin[l];
      longest = Max(longest, count[l]);
    }
  }
  COSPLAT_HD T Counts() const {
    PerLane<float, T> lanes;
    for (size_t l = 0; l < kLaneCount<T>; ++l) lanes[l] = float(count[l]);
    return FromLanes(lanes);
  }
};

template <class T>
struct VertexSums {
  Vec3<T> normal;
  Quat<T> rotation;
  T area;
};

// Sums over the faces around a vertex. Each rotation is added in the hemisphere of the sum so far,
// which therefore only grows: face rotations cannot cancel at a vertex.
template <class T>
COSPLAT_HD_FORCED VertexSums<T> SumFaces(const SurfaceArrays& s,
                                         const Fans<T>& fans,
                                         const Rows& rows) {
  const T zero(0.0f);
  VertexSums<T> sum{{zero, zero, zero}, {zero, zero, zero, zero}, zero};
  for (int32_t k = 0; k < fans.longest; ++k) {
    LaneRows<T> faces;
    for (size_t l = 0; l < kLaneCount<T>; ++l)
      faces[l] = k < fans.count[l] ? s.vertex_faces[fans.begin[l] + k] : int32_t(s.face_count);
    T row[kPosedFaceFloats];
    GatherRows<kPosedFaceFloats>(s.posed_faces, kPosedFaceFloats, faces, row);
    const PosedFace<T> face = PosedFaceOf(row);
    const T sign = HemisphereSign(sum.rotation, face.rotation);
    sum.normal += face.area_vector;
    sum.rotation = sum.rotation + face.rotation * (sign * face.area);
    sum.area += face.area;
    PerLane<float, T> signs;
    ToLanes(sign, signs);
    for (size_t l = 0; l < rows.count; ++l)
      if (k < fans.count[l]) s.signs[fans.begin[l] + k] = signs[l];
  }
  return sum;
}

// One row per vertex: from posed_faces, writes normal, rotation and area of the vertices, sums and
// signs.
template <class T>
COSPLAT_HD_FORCED void Run(const PoseVerticesKernel& kernel, const Rows& rows) {
  const SurfaceArrays& s = kernel.s;
  const T one(1.0f);
  const Fans<T> fans(s, rows);
  const VertexSums<T> sum = SumFaces<T>(s, fans, rows);
  // Face areas of a head are near 1e-5 square metres: the sum is scaled to norm 1 or less, because
  // the floor in Normalize is meant for quaternions of order 1.
  const auto some = sum.area > T(0.0f);
  const Quat<T> r = sum.rotation * (one / Select(some, sum.area, one));
  const T sums[kVertexSumFloats] = {sum.normal.x, sum.normal.y, sum.normal.z, r.w, r.x, r.y, r.z};
  StoreRows<kVertexSumFloats>(sums, s.sums, kVertexSumFloats, rows);
  const Vec3<T> n = Normalize(sum.normal);
  const Quat<T> q = Normalize(r);
  const T area = sum.area / Max(fans.Counts(), one);
  const T row[8] = {n.x, n.y, n.z, q.w, q.x, q.y, q.z, area};
  StoreRows<8>(row, s.vertices + 3, kSurfaceVertexFloats, rows);
}

// One row per vertex: the derivative of the sums over the faces, of normals, of rotations before
// the division by the area, and of areas. The division only changes the norm of the sum, which
// Normalize removes, so the area is treated as a constant there.
template <class T>
COSPLAT_HD_FORCED void Run(const VerticesVjpKernel& kernel, const Rows& rows) {
  const SurfaceArrays& s = kernel.s;
  const T zero(0.0f), one(1.0f);
  T row[kSurfaceVertexFloats], sum[kVertexSumFloats], mean_area[1];
  LoadRows<kSurfaceVertexFloats>(kernel.d_vertices, kSurfaceVertexFloats, rows, row);
  LoadRows<kVertexSumFloats>(s.sums, kVertexSumFloats, rows, sum);
  LoadRows<1>(s.vertices + kSurfaceVertexFloats - 1, kSurfaceVertexFloats, rows, mean_area);
  const T count = Max(Fans<T>(s, rows).Counts(), one);
  const T area = mean_area[0] * count;
  const auto some = area > zero;
  SurfaceVertex<T> d = SurfaceVertexOf(row);
  d.normal = NormalizeVjp(Vec3<T>{sum[0], sum[1], sum[2]}, d.normal);
  d.rotation = NormalizeVjp(Quat<T>{sum[3], sum[4], sum[5], sum[6]}, d.rotation) *
               Select(some, one / Select(some, area, one), zero);
  d.area = d.area / count;
  StoreSurfaceVertex(d, kernel.d_sums, kSurfaceVertexFloats, rows);
}

// The signs with which the faces' rotations were added at one of their corners.
template <class T>
COSPLAT_HD T SignsOf(const SurfaceArrays& s, const Rows& rows, int corner) {
  PerLane<float, T> signs;
  for (size_t l = 0; l < kLaneCount<T>; ++l) {
    const size_t f = rows.first + (l < rows.count ? l : 0);
    signs[l] = s.signs[s.corner_places[3 * f + size_t(corner)]];
  }
  return FromLanes(signs);
}

// One row per face: the derivative of its corners' positions.
template <class T>
COSPLAT_HD_FORCED void Run(const FacesVjpKernel& kernel, const Rows& rows) {
  const SurfaceArrays& s = kernel.s;
  const T zero(0.0f);
  const FaceCorners<T> at = LoadCorners<T>(s, rows);
  Mat3<T> canonical;
  LoadRows<9>(s.canonical_frames, 9, rows, canonical.m);
  T posed[kPosedFaceFloats];
  LoadRows<kPosedFaceFloats>(s.posed_faces, kPosedFaceFloats, rows, posed);
  const PosedFace<T> face = PosedFaceOf(posed);
  Vec3<T> d_vector{zero, zero, zero};
  Quat<T> d_rotation{zero, zero, zero, zero};
  T d_area = zero;
  for (int c = 0; c < 3; ++c) {
    T row[kSurfaceVertexFloats];
    GatherRows<kSurfaceVertexFloats>(
        kernel.d_sums, kSurfaceVertexFloats, CornerVertices<T>(s, rows, c), row);
    const SurfaceVertex<T> d = SurfaceVertexOf(row);
    const T sign = SignsOf<T>(s, rows, c);
    d_vector += d.normal;
    d_rotation = d_rotation + d.rotation * (sign * face.area);
    d_area += d.area + sign * Dot(face.rotation, d.rotation);
  }
  d_vector += LengthVjp(face.area_vector, d_area);
  Vec3<T> d[3];
  for (Vec3<T>& corner : d) corner = {zero, zero, zero};
  AreaVectorVjp(at.p[0], at.p[1], at.p[2], d_vector, d[0], d[1], d[2]);
  FaceRotationVjp(at.p[0], at.p[1], at.p[2], canonical, d_rotation, d[0], d[1], d[2]);
  const T row[9] = {d[0].x, d[0].y, d[0].z, d[1].x, d[1].y, d[1].z, d[2].x, d[2].y, d[2].z};
  StoreRows<9>(row, kernel.d_corners, 9, rows);
}

// One vertex per index.
struct PutPositionsKernel {
  const float* positions;  // [V, 3]
  float* vertices;         // [V, kSurfaceVertexFloats]

  COSPLAT_HD void operator()(size_t v) const {
    for (size_t k = 0; k < 3; ++k) vertices[kSurfaceVertexFloats * v + k] = positions[3 * v + k];
  }
};

// One vertex per index: sums its own derivative and those of the corners around it, in the order of
// the faces.
struct SumCornersKernel {
  SurfaceArrays s;
  const float* d_sums;     // [V, kSurfaceVertexFloats]
  const float* d_corners;  // [F, 3, 3]
  float* d_vertices;       // [V, 3]

  COSPLAT_HD void operator()(size_t v) const {
    const float* own = d_sums + kSurfaceVertexFloats * v;
    Vec3<float> sum{own[0], own[1], own[2]};
    for (int32_t k = s.vertex_face_begin[v]; k < s.vertex_face_begin[v + 1]; ++k) {
      const size_t f = size_t(s.vertex_faces[k]);
      const float* d = d_corners + 9 * f + 3 * CornerOf(s.faces + 3 * f, v);
      sum += Vec3<float>{d[0], d[1], d[2]};
    }
    d_vertices[3 * v] = sum.x;
    d_vertices[3 * v + 1] = sum.y;
    d_vertices[3 * v + 2] = sum.z;
  }
};

COSPLAT_MATH_END
#endif
