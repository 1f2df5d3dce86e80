// Loads and stores shared by the kernels of avatar/surface/kernels/, above all gathers: each lane
// of a kernel's scalar T reads a row of its own. A float has one lane; SIMD packs have their own
// overloads (avatar/surface/gather_rows.h).
#if defined(COSPLAT_AVATAR_KERNELS_GATHER_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef COSPLAT_AVATAR_KERNELS_GATHER_H_
#undef COSPLAT_AVATAR_KERNELS_GATHER_H_
#else
#define COSPLAT_AVATAR_KERNELS_GATHER_H_
#endif

#include <cstdint>

#include "avatar/math/embed.h"
#include "avatar/surface/kernels/arrays.h"
#include "splat/math/rows.h"

// For kernel bodies and functions that pass many packs, which g++ would otherwise pass through
// memory (a tenth of the time of binding).
#undef COSPLAT_HD_FORCED
#if defined(__CUDACC__)
#define COSPLAT_HD_FORCED __host__ __device__ __forceinline__
#else
#define COSPLAT_HD_FORCED __attribute__((always_inline)) inline
#endif

COSPLAT_MATH_BEGIN

template <class T>
inline constexpr size_t kLaneCount = 1;

// One number per lane.
template <class Number, class T>
struct PerLane {
  alignas(T) Number lane[kLaneCount<T>];
  COSPLAT_HD Number& operator[](size_t l) { return lane[l]; }
  COSPLAT_HD const Number& operator[](size_t l) const { return lane[l]; }
};
template <class T>
using LaneRows = PerLane<int32_t, T>;

// number_of(row) for the row of each lane; lanes beyond the last row repeat the first.
template <class T, class F>
COSPLAT_HD_FORCED LaneRows<T> RowPerLane(const Rows& rows, const F& number_of) {
  LaneRows<T> r;
  for (size_t l = 0; l < kLaneCount<T>; ++l)
    r[l] = number_of(rows.first + (l < rows.count ? l : 0));
  return r;
}

COSPLAT_HD float FromLanes(const PerLane<float, float>& lanes) { return lanes[0]; }
COSPLAT_HD void ToLanes(float x, PerLane<float, float>& lanes) { lanes[0] = x; }

// out[k] = number k of each row, for k < kUsed; 4 <= kUsed <= width.
template <int kUsed>
COSPLAT_HD void GatherRows(const float* array,
                           size_t width,
                           const LaneRows<float>& rows,
                           float* out) {
  for (int k = 0; k < kUsed; ++k) out[k] = array[width * size_t(rows[0]) + k];
}

template <class T>
COSPLAT_HD_FORCED void StoreVec3(const Vec3<T>& v, float* array, const Rows& rows) {
  const T out[3] = {v.x, v.y, v.z};
  StoreRows<3>(out, array, 3, rows);
}
template <class T>
COSPLAT_HD_FORCED void StoreQuat(const Quat<T>& q, float* array, const Rows& rows) {
  const T out[4] = {q.w, q.x, q.y, q.z};
  StoreRows<4>(out, array, 4, rows);
}

// Rows of kSurfaceVertexFloats and of kPosedFaceFloats.

template <class T>
COSPLAT_HD_FORCED SurfaceVertex<T> SurfaceVertexOf(const T* v) {
  return {{v[0], v[1], v[2]}, {v[3], v[4], v[5]}, {v[6], v[7], v[8], v[9]}, v[10]};
}
template <class T>
COSPLAT_HD_FORCED void StoreSurfaceVertex(const SurfaceVertex<T>& v,
                                          float* array,
                                          size_t width,
                                          const Rows& rows) {
  const T row[kSurfaceVertexFloats] = {v.position.x,
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
  StoreRows<kSurfaceVertexFloats>(row, array, width, rows);
}

template <class T>
struct PosedFace {
  Vec3<T> area_vector;
  T area;
  Quat<T> rotation;  // canonical to posed
};
template <class T>
COSPLAT_HD_FORCED PosedFace<T> PosedFaceOf(const T* v) {
  return {{v[0], v[1], v[2]}, v[3], {v[4], v[5], v[6], v[7]}};
}

COSPLAT_MATH_END
#endif
