// The colour of a photograph in that of the scene: an affine function with the numbers E, [3, 4]
// row-major, for exposure, white balance and veiling glare (3DGS's released code).
//   y = E[:, :3] x + E[:, 3]
#if defined(COSPLAT_SPLAT_MATH_EXPOSURE_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef COSPLAT_SPLAT_MATH_EXPOSURE_H_
#undef COSPLAT_SPLAT_MATH_EXPOSURE_H_
#else
#define COSPLAT_SPLAT_MATH_EXPOSURE_H_
#endif

#include "splat/math/vec.h"

COSPLAT_MATH_BEGIN

constexpr int kExposureNumbers = 12;

template <class T>
COSPLAT_HD Vec3<T> Exposed(const T* e, const Vec3<T>& x) {
  return {e[0] * x.x + e[1] * x.y + e[2] * x.z + e[3],
          e[4] * x.x + e[5] * x.y + e[6] * x.z + e[7],
          e[8] * x.x + e[9] * x.y + e[10] * x.z + e[11]};
}
// Adds d_e; returns d_x.
template <class T>
COSPLAT_HD Vec3<T> ExposedVjp(const T* e, const Vec3<T>& x, const Vec3<T>& d_y, T* d_e) {
  const T d[3] = {d_y.x, d_y.y, d_y.z};
  for (int r = 0; r < 3; ++r) {
    d_e[4 * r] = d_e[4 * r] + d[r] * x.x;
    d_e[4 * r + 1] = d_e[4 * r + 1] + d[r] * x.y;
    d_e[4 * r + 2] = d_e[4 * r + 2] + d[r] * x.z;
    d_e[4 * r + 3] = d_e[4 * r + 3] + d[r];
  }
  return {e[0] * d[0] + e[4] * d[1] + e[8] * d[2],
          e[1] * d[0] + e[5] * d[1] + e[9] * d[2],
          e[2] * d[0] + e[6] * d[1] + e[10] * d[2]};
}

COSPLAT_MATH_END
#endif
