// Three floats. (Eigen's expression templates easily dangle when returned from lambdas.)
#pragma once

#include <cmath>

namespace cosplat::procedural {

constexpr float kDegree = 0.01745329f;  // radians

struct Vec {
  float x = 0, y = 0, z = 0;

  float operator[](int i) const { return i == 0 ? x : i == 1 ? y : z; }
  float& operator[](int i) { return i == 0 ? x : i == 1 ? y : z; }
  Vec operator-() const { return {-x, -y, -z}; }
  Vec& operator+=(const Vec& b) {
    x += b.x, y += b.y, z += b.z;
    return *this;
  }
};

inline Vec operator+(const Vec& a, const Vec& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec operator-(const Vec& a, const Vec& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec operator*(const Vec& a, float s) { return {a.x * s, a.y * s, a.z * s}; }
inline Vec operator*(float s, const Vec& a) { return a * s; }
inline Vec operator*(const Vec& a, const Vec& b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }
inline Vec operator/(const Vec& a, const Vec& b) { return {a.x / b.x, a.y / b.y, a.z / b.z}; }
inline float Dot(const Vec& a, const Vec& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vec Cross(const Vec& a, const Vec& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline float Length(const Vec& a) { return std::sqrt(Dot(a, a)); }
inline Vec Normalized(const Vec& a) {
  const float n = Length(a);
  return n > 1e-20f ? a * (1 / n) : a;
}
inline Vec Mix(const Vec& a, const Vec& b, float t) { return a + (b - a) * t; }
inline float Mix(float a, float b, float t) { return a + (b - a) * t; }

}  // namespace cosplat::procedural
