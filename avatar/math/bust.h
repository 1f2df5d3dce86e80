// The rigid motion of an avatar's bust, and its derivative.
//
//   p' = R(turn) (p - pivot) + pivot + shift
//
// p: the bust's mean place in the world, pivot: the middle of its collar there, so that turning
// moves the collar least. The derivative is with respect to a small rotation w that follows the
// turn, R(exp(w)) R(turn), and to the shift, as a sum over the Gaussians on the bust:
//   d_shift = sum d_mean
//   d_w     = sum (mean - pivot - shift) x d_mean + vec(d_q conj(q)) / 2 for each quaternion q
#if defined(COSPLAT_AVATAR_MATH_BUST_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef COSPLAT_AVATAR_MATH_BUST_H_
#undef COSPLAT_AVATAR_MATH_BUST_H_
#else
#define COSPLAT_AVATAR_MATH_BUST_H_
#endif

#include "splat/math/quat.h"

COSPLAT_MATH_BEGIN

template <class T>
struct BustMotion {
  Quat<T> turn;   // unit
  Vec3<T> shift;  // metres
};

template <class T>
COSPLAT_HD Vec3<T> MoveWithBust(const BustMotion<T>& motion,
                                const Vec3<T>& pivot,
                                const Vec3<T>& p) {
  return RotationOf(motion.turn) * (p - pivot) + pivot + motion.shift;
}

// The derivative for one moved point with derivative d; adds to d_w and d_shift.
template <class T>
COSPLAT_HD void MoveWithBustVjp(const BustMotion<T>& motion,
                                const Vec3<T>& pivot,
                                const Vec3<T>& moved,
                                const Vec3<T>& d,
                                Vec3<T>& d_w,
                                Vec3<T>& d_shift) {
  d_shift += d;
  d_w += Cross(moved - pivot - motion.shift, d);
}
// The same for a quaternion q that the motion has turned; adds to d_w.
template <class T>
COSPLAT_HD void TurnWithBustVjp(const Quat<T>& q, const Quat<T>& d, Vec3<T>& d_w) {
  const Quat<T> product = Multiply(d, Conjugate(q));
  d_w += Vec3<T>{product.x, product.y, product.z} * T(0.5f);
}

// R(exp(w)) R(turn), to second order in w; w must be small.
template <class T>
COSPLAT_HD Quat<T> TurnedBy(const Vec3<T>& w, const Quat<T>& turn) {
  return Normalize(Multiply(Quat<T>{T(1), w.x * T(0.5f), w.y * T(0.5f), w.z * T(0.5f)}, turn));
}

COSPLAT_MATH_END
#endif
