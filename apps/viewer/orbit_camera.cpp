#include "apps/viewer/orbit_camera.h"

#include <algorithm>
#include <cmath>

#include "splat/math/quat.h"

namespace cosplat::viewer {
namespace {

using math::Mat3;
using math::Vec3;

constexpr float kZoomPerStep = 0.9f;
constexpr float kNearest = 1 / 50.0f, kFarthest = 20;  // relative to the initial distance
constexpr float kMaxElevation = 1.5f;  // radians; short of the poles, where up is undefined

Vec3<float> Row(const Mat3<float>& m, int r) { return {m(r, 0), m(r, 1), m(r, 2)}; }

Mat3<float> Turn(const Vec3<float>& axis, float angle) {
  const Vec3<float> v = axis * std::sin(angle / 2);
  return math::RotationOf(math::Quat<float>{std::cos(angle / 2), v.x, v.y, v.z});
}

// Removes the accumulated rounding error of many small rotations.
Mat3<float> Orthonormal(const Mat3<float>& m) {
  const Vec3<float> z = math::Normalize(Row(m, 2));
  const Vec3<float> y = math::Normalize(Row(m, 1) - z * math::Dot(z, Row(m, 1)));
  const Vec3<float> x = math::Cross(y, z);
  return {{x.x, x.y, x.z, y.x, y.y, y.z, z.x, z.y, z.z}};
}

// seen: a point in the camera's frame, in front of it.
bool IsInImage(const Camera& lens, const Vec3<float>& seen) {
  const float x = lens.cx + lens.fx * seen.x / seen.z, y = lens.cy + lens.fy * seen.y / seen.z;
  return x >= 0 && x <= float(lens.width) && y >= 0 && y <= float(lens.height);
}

}  // namespace

Camera Looking(Camera lens,
               const Vec3<float>& eye,
               const Vec3<float>& forward,
               const Vec3<float>& up) {
  const Vec3<float> x = math::Normalize(math::Cross(forward, up)), y = math::Cross(forward, x);
  lens.rotation = {x.x, x.y, x.z, y.x, y.y, y.z, forward.x, forward.y, forward.z};
  lens.translation = {-math::Dot(x, eye), -math::Dot(y, eye), -math::Dot(forward, eye)};
  return lens;
}

OrbitCamera::OrbitCamera(const StartView& start)
    : lens_(start.camera), up_(math::Normalize(math::ToVec3(start.up))) {
  std::copy(lens_.rotation.begin(), lens_.rotation.end(), home_.cam_from_world.m);
  const Vec3<float> eye = math::ToVec3(lens_.Center()), arm = math::ToVec3(start.center) - eye;
  const Vec3<float> seen = home_.cam_from_world * arm;
  const float length = std::sqrt(math::Dot(arm, arm));
  const bool in_front = seen.z > 0.05f * length;
  if (in_front && IsInImage(lens_, seen)) {
    home_.target = math::ToVec3(start.center);
    home_.distance = seen.z;
    ray_ = seen * (1 / seen.z);
  } else {  // There is no better estimate than a point on the axis.
    home_.distance = in_front ? seen.z : length > 0 ? length : 1;
    home_.target = eye + Row(home_.cam_from_world, 2) * home_.distance;
  }
  pose_ = home_;
}

void OrbitCamera::Orbit(float right, float upwards) {
  const Mat3<float>& r = pose_.cam_from_world;
  const Vec3<float> forward = Row(r, 2);
  const float elevation = -std::asin(std::clamp(math::Dot(forward, up_), -1.0f, 1.0f));
  const float limit = std::max(kMaxElevation, std::abs(elevation));
  const float rise = std::clamp(elevation + upwards, -limit, limit) - elevation;
  // The horizontal right axis, or the camera's own x axis if it looks straight up or down.
  Vec3<float> level = math::Cross(forward, up_);
  if (math::Dot(level, level) < 1e-6f) level = Row(r, 0);
  const Mat3<float> pitched = r * Turn(math::Normalize(level), rise);
  pose_.cam_from_world = Orthonormal(pitched * math::Transpose(Turn(up_, right)));
}

void OrbitCamera::Pan(float right, float down) {
  const float height = float(lens_.height) / lens_.fy * pose_.distance;
  pose_.target = pose_.target - Row(pose_.cam_from_world, 0) * (right * height) -
                 Row(pose_.cam_from_world, 1) * (down * height);
}

void OrbitCamera::Zoom(float steps) {
  const float distance = pose_.distance * std::pow(kZoomPerStep, steps);
  pose_.distance = std::clamp(distance, kNearest * home_.distance, kFarthest * home_.distance);
}

void OrbitCamera::Reset() { pose_ = home_; }

Camera OrbitCamera::At(int width, int height) const {
  const float scale =
      std::min(float(width) / float(lens_.width), float(height) / float(lens_.height));
  Camera camera;
  camera.width = width;
  camera.height = height;
  camera.near_plane = lens_.near_plane;
  camera.fx = lens_.fx * scale;
  camera.fy = lens_.fy * scale;
  camera.cx = 0.5f * float(width) + (lens_.cx - 0.5f * float(lens_.width)) * scale;
  camera.cy = 0.5f * float(height) + (lens_.cy - 0.5f * float(lens_.height)) * scale;
  const Mat3<float>& r = pose_.cam_from_world;
  const Vec3<float> t = ray_ * pose_.distance - r * pose_.target;
  std::copy(r.m, r.m + 9, camera.rotation.begin());
  camera.translation = {t.x, t.y, t.z};
  return camera;
}

}  // namespace cosplat::viewer
