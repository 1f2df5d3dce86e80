#include "avatar/plugin/host_camera.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "avatar/plugin/coded_error.h"
#include "splat/base/camera.h"
#include "splat/base/image.h"
#include "splat/base/text.h"
#include "splat/math/vec.h"

namespace cosplat::plugin {
namespace {

using math::Vec3;

constexpr uint64_t kMaxPixels = uint64_t(1) << 26;
// Larger than needed for any lens and any room, and far within the range of floats.
constexpr float kMaxCameraNumber = 1e7f;

constexpr float kMaxElevation = 1.5f;  // short of the poles, where the up direction is undefined
constexpr float kMaxAzimuth = 1000;    // many turns, but floats still resolve single degrees
constexpr float kMaxZoom = 100;

void CheckBetween(float value, float min, float max, const char* field) {
  if (!std::isfinite(value))
    throw CodedError(COSPLAT_ERROR_NOT_FINITE, field, std::to_string(value) + " is not finite");
  if (value < min || value > max) Refuse(field, Format("{} is not from {} to {}", value, min, max));
}

}  // namespace

void CheckSize(uint32_t width, uint32_t height, const char* name) {
  if (width < 1 || height < 1 || width > COSPLAT_LARGEST_SIDE || height > COSPLAT_LARGEST_SIDE ||
      uint64_t(width) * height > kMaxPixels)
    Refuse(std::string(name) + ".width, height",
           SizeText(width, height) + " pixels: sides are from 1 to " +
               std::to_string(COSPLAT_LARGEST_SIDE) + ", at most " + std::to_string(kMaxPixels) +
               " pixels in all");
}

Camera ToCamera(const cosplat_camera& given) {
  CheckSize(given.width, given.height, "camera");
  const float min_focal = 1 / kMaxCameraNumber;
  CheckBetween(given.fx, min_focal, kMaxCameraNumber, "camera.fx");
  CheckBetween(given.fy, min_focal, kMaxCameraNumber, "camera.fy");
  CheckBetween(given.cx, -kMaxCameraNumber, kMaxCameraNumber, "camera.cx");
  CheckBetween(given.cy, -kMaxCameraNumber, kMaxCameraNumber, "camera.cy");
  std::array<double, 9> rotation;
  std::array<double, 3> translation;
  for (size_t i = 0; i < 3; ++i) {
    for (size_t k = 0; k < 4; ++k) {
      const float x = given.cam_from_world[4 * i + k];
      CheckBetween(x, -kMaxCameraNumber, kMaxCameraNumber, "camera.cam_from_world");
      (k < 3 ? rotation[3 * i + k] : translation[i]) = x;
    }
  }
  Camera camera;
  camera.width = int(given.width);
  camera.height = int(given.height);
  camera.fx = given.fx;
  camera.fy = given.fy;
  camera.cx = given.cx;
  camera.cy = given.cy;
  const PoseProblem problem = SetPose(rotation, translation, camera);
  if (!problem.empty()) Refuse("camera.cam_from_world", problem);
  return camera;
}

cosplat_camera FromCamera(const Camera& camera) {
  cosplat_camera out{};
  out.width = uint32_t(camera.width);
  out.height = uint32_t(camera.height);
  out.fx = camera.fx;
  out.fy = camera.fy;
  out.cx = camera.cx;
  out.cy = camera.cy;
  for (size_t i = 0; i < 3; ++i) {
    std::copy_n(&camera.rotation[3 * i], 3, &out.cam_from_world[4 * i]);
    out.cam_from_world[4 * i + 3] = camera.translation[i];
  }
  return out;
}

Camera OrbitCamera(const HeadPlace& head, uint32_t width, uint32_t height, const Orbit& orbit) {
  CheckSize(width, height, "camera");
  CheckBetween(orbit.azimuth, -kMaxAzimuth, kMaxAzimuth, "azimuth");
  CheckBetween(orbit.elevation, -kMaxElevation, kMaxElevation, "elevation");
  CheckBetween(orbit.zoom, 1 / kMaxZoom, kMaxZoom, "zoom");
  const float sa = std::sin(orbit.azimuth), ca = std::cos(orbit.azimuth);
  const float se = std::sin(orbit.elevation), ce = std::cos(orbit.elevation);
  // The camera looks back at the face.
  const Vec3<float> back = head.world_from_head * Vec3<float>{sa * ce, se, ca * ce};
  const Vec3<float> right = head.world_from_head * Vec3<float>{ca, 0, -sa};
  const Vec3<float> down = head.world_from_head * Vec3<float>{sa * se, -ce, ca * se};
  const float side = float(std::min(width, height));
  const float distance = kPortraitFocal * head.extent / kPortraitShare;

  Camera camera;
  camera.width = int(width);
  camera.height = int(height);
  camera.fx = camera.fy = kPortraitFocal * side * orbit.zoom;
  camera.cx = 0.5f * float(width);
  camera.cy = 0.5f * float(height);
  const Vec3<float> rows[3] = {right, down, back * -1.0f};
  for (size_t i = 0; i < 3; ++i) {
    camera.rotation[3 * i] = rows[i].x;
    camera.rotation[3 * i + 1] = rows[i].y;
    camera.rotation[3 * i + 2] = rows[i].z;
    camera.translation[i] = -math::Dot(rows[i], head.center) + (i == 2 ? distance : 0);
  }
  return camera;
}

}  // namespace cosplat::plugin
