// How an element-wise kernel reads and writes arrays [N, width]: one row per lane of its scalar T.
// A float has one lane; SIMD packs have their own overloads (splat/render/cpu/pack_rows.h).
#if defined(COSPLAT_SPLAT_KERNELS_ROWS_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef COSPLAT_SPLAT_KERNELS_ROWS_H_
#undef COSPLAT_SPLAT_KERNELS_ROWS_H_
#else
#define COSPLAT_SPLAT_KERNELS_ROWS_H_
#endif

#include <cstddef>

#include "splat/math/quat.h"

COSPLAT_MATH_BEGIN

// Rows [first, first + count) of an array; 1 <= count <= the lanes of T.
struct Rows {
  size_t first;
  size_t count;
};

// out[k]: value k of each row, k < kUsed <= width. Lanes beyond the rows hold values of some row.
template <int kUsed>
COSPLAT_HD void LoadRows(const float* array, size_t width, const Rows& rows, float* out) {
  for (int k = 0; k < kUsed; ++k) out[k] = array[width * rows.first + k];
}
// The reverse; a row's values beyond kUsed are unchanged.
template <int kUsed>
COSPLAT_HD void StoreRows(const float* in, float* array, size_t width, const Rows& rows) {
  for (int k = 0; k < kUsed; ++k) array[width * rows.first + k] = in[k];
}

template <class T>
COSPLAT_HD Vec3<T> LoadVec3(const float* array, const Rows& rows) {
  T v[3];
  LoadRows<3>(array, 3, rows, v);
  return {v[0], v[1], v[2]};
}
template <class T>
COSPLAT_HD Quat<T> LoadQuat(const float* array, const Rows& rows) {
  T v[4];
  LoadRows<4>(array, 4, rows, v);
  return {v[0], v[1], v[2], v[3]};
}
template <class T>
COSPLAT_HD T LoadScalar(const float* array, const Rows& rows) {
  T v[1];
  LoadRows<1>(array, 1, rows, v);
  return v[0];
}

// Stores each lane's value where `mask` is set, otherwise 0.
template <class Mask, class T>
COSPLAT_HD void StoreWhere(Mask mask, const Vec3<T>& v, float* array, const Rows& rows) {
  const T out[3] = {Select(mask, v.x, T(0)), Select(mask, v.y, T(0)), Select(mask, v.z, T(0))};
  StoreRows<3>(out, array, 3, rows);
}
template <class Mask, class T>
COSPLAT_HD void StoreWhere(Mask mask, const Quat<T>& q, float* array, const Rows& rows) {
  const T out[4] = {Select(mask, q.w, T(0)),
                    Select(mask, q.x, T(0)),
                    Select(mask, q.y, T(0)),
                    Select(mask, q.z, T(0))};
  StoreRows<4>(out, array, 4, rows);
}
template <class Mask, class T>
COSPLAT_HD void StoreWhere(Mask mask, const T& x, float* array, const Rows& rows) {
  const T out[1] = {Select(mask, x, T(0))};
  StoreRows<1>(out, array, 1, rows);
}
COSPLAT_HD void ZeroRows(float* array, size_t width, const Rows& rows) {
  for (size_t k = width * rows.first; k < width * (rows.first + rows.count); ++k) array[k] = 0;
}

COSPLAT_MATH_END
#endif
