// A right-handed pinhole camera, looking along +z with x right and y down (OpenCV). The world frame
// is that of the data set. Pixel centres lie at +0.5: the top-left pixel covers [0,1) x [0,1).
#pragma once

#include <array>
#include <string>
#include <vector>

namespace cosplat {

// Smallest depth that is drawn, world units (gsplat; 3DGS has 0.2, too far for a head in metres).
// In scenes of small units it is as many SmallUnits (splat/base/world_frame.h).
constexpr float kNearPlane = 0.01f;

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
  float near_plane = kNearPlane;                             // > 0

  bool operator==(const Camera&) const = default;

  // The camera's centre in the world: -R^T t.
  std::array<float, 3> Center() const {
    std::array<float, 3> c{};
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < 3; ++k) c[i] -= rotation[3 * k + i] * translation[k];
    return c;
  }

  // The same camera for another image size; intrinsics are scaled per axis.
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

// Validated camera poses: all loaders use these functions to set a Camera's cam_from_world.

// Empty if the pose is usable; otherwise the reason, with the offending value. A rotation may
// deviate from orthonormality by 1e-3 per entry of R R^T (text files round); it is then
// orthonormalised.
using PoseProblem = std::string;

// `rotation` (row-major) and `translation`: cam_from_world with OpenCV axes (x right, y down).
// center: if given, gets the camera's place in the world, which `camera` has as floats only.
PoseProblem SetPose(const std::array<double, 9>& rotation,
                    const std::array<double, 3>& translation,
                    Camera& camera,
                    std::array<double, 3>* center = nullptr);

// `matrix`: the upper 3x4 of world_from_cam, row-major, with OpenCV axes.
PoseProblem SetPoseFromWorldFromCam(const std::array<double, 12>& matrix,
                                    Camera& camera,
                                    std::array<double, 3>* center = nullptr);

// The same with OpenGL camera axes (x right, y up, looking along -z) as in NeRF's files. The world
// frame is unchanged.
PoseProblem SetPoseFromOpenGlWorldFromCam(const std::array<double, 12>& matrix,
                                          Camera& camera,
                                          std::array<double, 3>* center = nullptr);

// The upper 3x4, row-major, of a pose's matrix of 16 or 12 numbers as files have them. The last row
// of a 4x4 is 0 0 0 1; one whose last *column* is that is in the order of columns, and is
// transposed.
PoseProblem RowsOfPose(const std::vector<double>& numbers,
                       std::array<double, 12>& matrix,
                       bool& transposed);

// Why these are no lens's intrinsics in pixels, with the value, or "": a principal point in the
// image's corner, a field of view of 160 degrees and more, pixels 1.9 times as wide as high.
std::string LensProblem(const Camera& lens);

}  // namespace cosplat
