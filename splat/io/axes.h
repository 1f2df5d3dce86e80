// From OpenCV's axes to glTF's: half a turn about x.
//
// Scenes keep the world of their data, which for COLMAP's and most others' is OpenCV's manner: x
// right, y down, z away from the first camera. glTF has y up and z towards the viewer. The turn
// (x, y, z) -> (x, -y, -z) carries the one into the other and keeps right-handedness.
// FLAME's own axes (y up, the face towards +z, metres) are glTF's already: avatars are not turned.
#pragma once

#include "splat/gaussians.h"

namespace cosplat {

// +1 or -1: what coefficient k = l^2 + l + m of either basis is multiplied by, so that the colour
// seen along the turned direction is the one that was seen along the direction before.
// Y_l^m(x, -y, -z) = (-1)^(l + m) Y_l^m for m >= 0 and -(-1)^(l + m) Y_l^m for m < 0: -1 for
// k = 1, 2, 4, 7, 9, 11, 12, 14 up to degree 3.
float GltfTurnSign(int coefficient);

// Turns positions, rotations and colours. kPosition must be points in the world.
// Turning twice gives the same Gaussians (rotations up to their sign).
void TurnToGltfAxes(Gaussians& gaussians);

}  // namespace cosplat
