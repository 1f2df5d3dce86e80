#include "apps/cosplat/run/camera_path.h"

#include <algorithm>
#include <cmath>

#include "apps/viewer/orbit_camera.h"
#include "splat/math/quat.h"
#include "splat/train/start/initialize.h"

namespace cosplat {
namespace {

using math::Vec3;

constexpr float kPi = 3.14159265f;
// The path does not cross gaps between neighbouring azimuths that are wider than this.
constexpr float kMaxGap = kPi / 2;

// The target is in the middle of the image: a square of larger frames has the lens's axis
// elsewhere.
Camera LookAt(Camera lens, Vec3<float> eye, Vec3<float> target, Vec3<float> up) {
  lens.cx = float(lens.width) / 2;
  lens.cy = float(lens.height) / 2;
  return viewer::Looking(lens, eye, math::Normalize(target - eye), up);
}

// The azimuths to sweep: the complement of the largest gap between sorted angles.
struct Arc {
  float begin, length;
};
Arc CoveredArc(std::vector<float> angles) {
  std::sort(angles.begin(), angles.end());
  float gap = angles.front() + 2 * kPi - angles.back();
  float begin = angles.front();
  for (size_t i = 1; i < angles.size(); ++i)
    if (angles[i] - angles[i - 1] > gap) {
      gap = angles[i] - angles[i - 1];
      begin = angles[i];
    }
  return gap < kMaxGap ? Arc{begin, 2 * kPi} : Arc{begin, 2 * kPi - gap};
}

}  // namespace

std::vector<Camera> OrbitScene(const std::vector<Camera>& cameras, int frames) {
  const Vec3<float> focus = math::ToVec3(FocusPoint(cameras));
  Vec3<float> up{0, 0, 0};
  for (const Camera& c : cameras) up += {-c.rotation[3], -c.rotation[4], -c.rotation[5]};
  up = math::Normalize(up);
  const Vec3<float> first = math::ToVec3(cameras[0].Center()) - focus;
  const Vec3<float> axis_x = math::Normalize(first - up * math::Dot(first, up));
  const Vec3<float> axis_y = math::Cross(up, axis_x);
  float radius = 0, height = 0;
  std::vector<float> angles;
  for (const Camera& c : cameras) {
    const Vec3<float> p = math::ToVec3(c.Center()) - focus;
    const float x = math::Dot(p, axis_x), y = math::Dot(p, axis_y);
    angles.push_back(std::atan2(y, x));
    radius += std::hypot(x, y) / float(cameras.size());
    height += math::Dot(p, up) / float(cameras.size());
  }
  const Arc arc = CoveredArc(angles);
  const bool full = arc.length >= 2 * kPi;
  std::vector<Camera> path;
  for (int i = 0; i < frames; ++i) {
    const float t = float(i) / float(frames);
    const float angle = arc.begin + arc.length * (full ? t : 0.5f - 0.5f * std::cos(2 * kPi * t));
    const Vec3<float> eye =
        focus + up * height + (axis_x * std::cos(angle) + axis_y * std::sin(angle)) * radius;
    path.push_back(LookAt(cameras[0], eye, focus, up));
  }
  return path;
}

std::array<float, 3> MiddleOf(const std::vector<float>& vertices, int count) {
  std::array<float, 3> middle{};
  for (int v = 0; v < count; ++v)
    for (size_t k = 0; k < 3; ++k) middle[k] += vertices[3 * size_t(v) + k] / float(count);
  return middle;
}

Camera TurnedAround(const Camera& reference,
                    const std::array<float, 3>& target,
                    const std::array<float, 3>& up,
                    float degrees) {
  const Vec3<float> center = math::ToVec3(target), axis = math::Normalize(math::ToVec3(up));
  const float half = 0.5f * degrees * kPi / 180;
  const Vec3<float> v = axis * std::sin(half);
  const math::Mat3<float> turn = math::RotationOf(math::Quat<float>{std::cos(half), v.x, v.y, v.z});
  const Vec3<float> arm = math::ToVec3(reference.Center()) - center;
  return LookAt(reference, center + turn * arm, center, axis);
}

std::vector<Camera> SwingAround(const Camera& reference,
                                const std::array<float, 3>& target,
                                const std::array<float, 3>& up,
                                float degrees,
                                int frames) {
  std::vector<Camera> path;
  for (int i = 0; i < frames; ++i)
    path.push_back(TurnedAround(
        reference, target, up, degrees * std::sin(2 * kPi * float(i) / float(frames))));
  return path;
}

}  // namespace cosplat
