// The elementary functions that the formulas need of a scalar type T, for float and double. Dual
// numbers (tests/support/dual.h) and SIMD packs (splat/render/cpu/pack.h) have their own overloads.
#if defined(COSPLAT_SPLAT_MATH_SCALAR_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef COSPLAT_SPLAT_MATH_SCALAR_H_
#undef COSPLAT_SPLAT_MATH_SCALAR_H_
#else
#define COSPLAT_SPLAT_MATH_SCALAR_H_
#endif

#include <cmath>
#include <type_traits>

#include "splat/math/namespace.h"

COSPLAT_MATH_BEGIN

COSPLAT_HD float Sqrt(float x) { return std::sqrt(x); }
COSPLAT_HD double Sqrt(double x) { return std::sqrt(x); }
COSPLAT_HD float Exp(float x) { return std::exp(x); }
COSPLAT_HD double Exp(double x) { return std::exp(x); }
COSPLAT_HD float Log(float x) { return std::log(x); }
COSPLAT_HD double Log(double x) { return std::log(x); }
COSPLAT_HD float Sin(float x) { return std::sin(x); }
COSPLAT_HD double Sin(double x) { return std::sin(x); }
COSPLAT_HD float Cos(float x) { return std::cos(x); }
COSPLAT_HD double Cos(double x) { return std::cos(x); }
COSPLAT_HD float Abs(float x) { return std::fabs(x); }
COSPLAT_HD double Abs(double x) { return std::fabs(x); }

COSPLAT_HD bool And(bool a, bool b) { return a && b; }
// Whether any lane of a mask is set.
COSPLAT_HD bool AnyTrue(bool a) { return a; }

// condition ? a : b. With packs the condition is a mask and both sides are evaluated, so neither
// may trap or produce a NaN that matters.
template <class T>
COSPLAT_HD T Select(bool condition, const T& a, const T& b) {
  return condition ? a : b;
}
template <class T>
COSPLAT_HD T Min(const T& a, const T& b) {
  return Select(a < b, a, b);
}
template <class T>
COSPLAT_HD T Max(const T& a, const T& b) {
  return Select(a > b, a, b);
}
template <class T>
COSPLAT_HD T Clamp(const T& x, const T& low, const T& high) {
  return Min(Max(x, low), high);
}
// a / b for |b| in [2^-126, 2^126]; as a float on a CUDA device in a fifth of the instructions, to
// 2 ulp.
template <class T>
COSPLAT_HD T FastDivide(const T& a, const T& b) {
#if defined(__CUDA_ARCH__)
  if constexpr (std::is_same_v<T, float>) return __fdividef(a, b);
#endif
  return a / b;
}
template <class T>
COSPLAT_HD auto IsFinite(const T& x) {
  return Abs(x) < T(3e38f);
}
template <class T>
COSPLAT_HD T Sigmoid(const T& x) {
  return T(1) / (T(1) + Exp(-x));
}
// Inverse of Sigmoid, for 0 < y < 1.
inline float Logit(float y) { return std::log(y / (1 - y)); }
// d_x given y = Sigmoid(x).
template <class T>
COSPLAT_HD T SigmoidVjp(const T& y, const T& d_y) {
  return d_y * y * (T(1) - y);
}

COSPLAT_MATH_END
#endif
