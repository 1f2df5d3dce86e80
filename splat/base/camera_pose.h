// Checked camera poses: every loader's matrices end here, as Camera's cam_from_world.
#pragma once

#include <array>
#include <string>

#include "splat/base/camera.h"

namespace cosplat {

// Empty when the pose can be used; otherwise why not, with the offending value. A rotation may
// deviate from orthonormality by 1e-3 per entry of R R^T (text files round) and is made
// orthonormal.
using PoseProblem = std::string;

// `rotation` (row-major) and `translation`: cam_from_world with OpenCV axes (x right, y down).
PoseProblem SetPose(const std::array<double, 9>& rotation,
                    const std::array<double, 3>& translation,
                    Camera& camera);

// `matrix`: world_from_cam, 4x4 or its upper 3x4, row-major, with OpenGL camera axes (x right, y
// up, looking along -z) as NeRF's files have it. The world frame is left as it is.
PoseProblem SetPoseFromOpenGlWorldFromCam(const std::array<double, 12>& matrix, Camera& camera);

}  // namespace cosplat
