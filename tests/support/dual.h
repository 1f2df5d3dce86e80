// Forward-mode dual numbers: a + b*eps, eps^2 = 0. Instantiating a formula on Dual gives its exact
// directional derivative, which vouches for the hand-written VJP beneath it.
#pragma once

#include <cmath>

namespace cosplat::test {

struct Dual {
  double value = 0;
  double slope = 0;
  Dual() = default;
  Dual(double v, double s = 0) : value(v), slope(s) {}  // NOLINT: scalars convert
};

inline Dual operator+(Dual a, Dual b) { return {a.value + b.value, a.slope + b.slope}; }
inline Dual operator-(Dual a, Dual b) { return {a.value - b.value, a.slope - b.slope}; }
inline Dual operator-(Dual a) { return {-a.value, -a.slope}; }
inline Dual operator*(Dual a, Dual b) {
  return {a.value * b.value, a.value * b.slope + a.slope * b.value};
}
inline Dual operator/(Dual a, Dual b) {
  return {a.value / b.value, (a.slope * b.value - a.value * b.slope) / (b.value * b.value)};
}
inline Dual& operator+=(Dual& a, Dual b) { return a = a + b; }
inline Dual& operator-=(Dual& a, Dual b) { return a = a - b; }
inline Dual& operator*=(Dual& a, Dual b) { return a = a * b; }
inline bool operator<(Dual a, Dual b) { return a.value < b.value; }
inline bool operator>(Dual a, Dual b) { return a.value > b.value; }
inline bool operator<=(Dual a, Dual b) { return a.value <= b.value; }
inline bool operator>=(Dual a, Dual b) { return a.value >= b.value; }

inline Dual Sqrt(Dual a) {
  const double r = std::sqrt(a.value);
  return {r, a.slope / (2 * r)};
}
inline Dual Exp(Dual a) {
  const double e = std::exp(a.value);
  return {e, e * a.slope};
}
inline Dual Log(Dual a) { return {std::log(a.value), a.slope / a.value}; }
inline Dual Sin(Dual a) { return {std::sin(a.value), std::cos(a.value) * a.slope}; }
inline Dual Cos(Dual a) { return {std::cos(a.value), -std::sin(a.value) * a.slope}; }
inline Dual Abs(Dual a) { return a.value < 0 ? -a : a; }

}  // namespace cosplat::test
