// Cameras that look at a point.
#pragma once

#include <array>
#include <cmath>
#include <vector>

#include "splat/base/camera.h"

namespace cosplat::test {

using Point = std::array<float, 3>;

inline Point Cross(const Point& a, const Point& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline Point Unit(const Point& v) {
  const float n = std::hypot(v[0], v[1], v[2]);
  return {v[0] / n, v[1] / n, v[2] / n};
}

// A square image of `side` px; the field of view is 53 degrees.
inline Camera LookingAt(const Point& eye, const Point& target, int side = 48) {
  const Point z = Unit({target[0] - eye[0], target[1] - eye[1], target[2] - eye[2]});
  const Point x = Unit(Cross({0.1f, 1, 0.2f}, z)), y = Cross(z, x);
  Camera c;
  c.width = c.height = side;
  c.fx = c.fy = float(side);
  c.cx = c.cy = 0.5f * float(side);
  c.rotation = {x[0], x[1], x[2], y[0], y[1], y[2], z[0], z[1], z[2]};
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) c.translation[i] -= c.rotation[3 * i + k] * eye[k];
  return c;
}

// From the same place in the opposite direction: half a turn about the camera's y axis.
inline Camera TurnedAround(Camera camera) {
  for (const int row : {0, 2}) {
    for (int k = 0; k < 3; ++k) camera.rotation[3 * row + k] *= -1;
    camera.translation[row] *= -1;
  }
  return camera;
}

// `count` cameras around the origin, some higher, some lower, `distance` away.
inline std::vector<Camera> Ring(int count, float distance, int side = 48) {
  std::vector<Camera> cameras;
  for (int i = 0; i < count; ++i) {
    const float angle = 6.2831853f * float(i) / float(count), height = i % 2 ? 0.4f : -0.2f;
    const Point eye = Unit({std::cos(angle), height, std::sin(angle)});
    cameras.push_back(
        LookingAt({distance * eye[0], distance * eye[1], distance * eye[2]}, {0, 0, 0}, side));
  }
  return cameras;
}

}  // namespace cosplat::test
