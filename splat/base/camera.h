// A pinhole camera. Right-handed, looking along +z, x right, y down (OpenCV); the world frame is as
// the data has it. Pixel centres lie at +0.5: the top-left pixel covers [0,1) x [0,1).
#pragma once

#include <array>
#include <string>

namespace cosplat {

struct Camera {
  int width = 0;   // px
  int height = 0;  // px
  float fx = 0;    // px
  float fy = 0;    // px
  float cx = 0;    // px from the left edge of the image
  float cy = 0;    // px from the top edge
  // cam_from_world: p_in_cam = rotation * p_in_world + translation.
  std::array<float, 9> rotation{1, 0, 0, 0, 1, 0, 0, 0, 1};  // row-major, orthonormal
  std::array<float, 3> translation{0, 0, 0};                 // world units

  // The camera's centre in the world: -R^T t.
  std::array<float, 3> Center() const {
    std::array<float, 3> c{};
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < 3; ++k) c[i] -= rotation[3 * k + i] * translation[k];
    return c;
  }

  // The same camera with an image of another size: intrinsics scale per axis.
  Camera Resized(int new_width, int new_height) const {
    Camera c = *this;
    const float sx = float(new_width) / width;
    const float sy = float(new_height) / height;
    c.width = new_width;
    c.height = new_height;
    c.fx *= sx;
    c.cx *= sx;
    c.fy *= sy;
    c.cy *= sy;
    return c;
  }
};

// Checked camera poses: every loader's matrices end here, as Camera's cam_from_world.

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
