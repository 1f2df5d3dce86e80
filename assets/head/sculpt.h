// The procedural head's solid shape: a signed distance of smoothly joined primitives.
//
// sculpt -> mesh (vertices are projected and relaxed onto the zero level set) -> rig -> FlameModel.
// Frame: FLAME's (metres, y up, face towards +z, the subject's left at +x), origin inside the head
// between the ears. Proportions: averages of adult anthropometry (head 225 mm high, eyes at half of
// that, 64 mm between the pupils, equal thirds hairline / brow / nose base / chin).
#pragma once

#include <algorithm>
#include <cmath>

#include "assets/head/vec.h"

namespace cosplat::procedural {

// Landmarks shared by mesh, rig and appearance.
constexpr float kEyeX = 0.032f;
constexpr float kEyeY = 0.030f;
constexpr float kEyeZ = 0.0400f;
constexpr float kEyeRadius = 0.0140f;       // sclera
constexpr float kLidInnerRadius = 0.0152f;  // clears the cornea, which protrudes by 0.5 mm
constexpr float kLidOuterRadius = 0.0166f;
constexpr float kMouthY = -0.0412f;
constexpr float kMouthHalfWidth = 0.0262f;
constexpr float kBustBottom = -0.168f;

inline float SmoothStep(float low, float high, float x) {
  const float t = std::clamp((x - low) / (high - low), 0.0f, 1.0f);
  return t * t * (3 - 2 * t);
}

// exp(-(x / width)^2), truncated to 0 beyond three widths (where it is below 2e-4).
inline float BellOfSquare(float x_squared, float width) {
  const float t = x_squared / (width * width);
  return t < 9 ? std::exp(-t) : 0;
}
inline float Bell(float x, float width) { return BellOfSquare(x * x, width); }
inline float Ball(const Vec& p, const Vec& center, float width) {
  return BellOfSquare(Dot(p - center, p - center), width);
}

// Distance to skin and clothing, without hair; approximately metric near the surface.
float SkinDistance(const Vec& p);

// Distance of a scalp point inside the hair's outline, metres (negative: bare skin).
float HairInside(const Vec& p);

// The surface that is meshed: skin plus the hair's volume.
float HeadDistance(const Vec& p);
Vec HeadGradient(const Vec& p);

// Moves p along the gradient onto the zero level set.
Vec ProjectToHead(Vec p);

// First hit of a ray from far outside towards `origin` along -direction (unit length).
Vec CastOntoHead(const Vec& origin, const Vec& direction);

// Share of the sky visible from a point of the rest shape, [0, 1], from distances along its normal.
float AmbientOcclusion(const Vec& p, const Vec& normal);

// Shape of the palpebral fissure, shared by the mesh (open lids) and the rig (closed lids).
//
// Directions from the eyeball's centre in degrees: azimuth from straight ahead towards the temple,
// elevation upwards. `along` goes from -1 at the medial to 1 at the lateral corner.

float LidAzimuth(float along);
float UpperLidElevation(float along);
float LowerLidElevation(float along);
float ClosedLidElevation(float along);

// Point at `radius` from the centre of the left or right eye.
Vec AroundEye(bool left, float azimuth, float elevation, float radius);

struct EyeAngles {
  float azimuth, elevation, radius;
};
EyeAngles AnglesAroundEye(bool left, const Vec& p);

Vec EyeCenter(bool left);

}  // namespace cosplat::procedural
