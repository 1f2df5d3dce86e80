// Shape of the palpebral fissure, shared by the mesh (open lids) and the rig (closed lids).
//
// Directions from the eyeball's centre in degrees: azimuth from straight ahead towards the temple,
// elevation upwards. `along` goes from -1 at the medial to 1 at the lateral corner.
#pragma once

#include "assets/head/sculpt.h"

namespace cosplat::procedural {

float LidAzimuth(float along);
float UpperLidElevation(float along);
float LowerLidElevation(float along);
float ClosedLidElevation(float along);

// The point at `radius` from the centre of the left or right eye.
Vec AroundEye(bool left, float azimuth, float elevation, float radius);

struct EyeAngles {
  float azimuth, elevation, radius;
};
EyeAngles AnglesAroundEye(bool left, const Vec& p);

Vec EyeCenter(bool left);

}  // namespace cosplat::procedural
