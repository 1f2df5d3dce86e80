// The vectors that the head is modelled and painted with: positions in metres, directions, and
// colours, which light multiplies element by element.
#pragma once

#include "splat/math/vec.h"

namespace cosplat::procedural {

using Vec = math::Vec3<float>;

constexpr float kDegree = 0.01745329f;  // radians

inline Vec operator*(const Vec& a, const Vec& b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }
inline Vec operator/(const Vec& a, const Vec& b) { return {a.x / b.x, a.y / b.y, a.z / b.z}; }
inline Vec Mix(const Vec& a, const Vec& b, float t) { return a + (b - a) * t; }
inline float Mix(float a, float b, float t) { return a + (b - a) * t; }

}  // namespace cosplat::procedural
