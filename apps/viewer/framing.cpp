#include <algorithm>
#include <cmath>
#include <string>

#include "apps/viewer/orbit_camera.h"
#include "avatar/model/avatar_mesh.h"
#include "splat/base/error.h"
#include "splat/base/world_frame.h"
#include "splat/config.h"
#include "splat/math/scalar.h"
#include "splat/train/start/initialize.h"

namespace cosplat::viewer {
namespace {

using math::Vec3;

constexpr int kSide = 768;           // image size of generated cameras; px
constexpr float kSceneFocal = 1.2f;  // in image heights: 45 degrees
// Splats farther from a scene's centre than this multiple of the median distance count as
// surroundings or strays; this share of the others should be in the image.
constexpr float kFarthestOfHalf = 3, kMax = 0.99f;
constexpr float kSceneMargin = 1.1f;

// Camera at `distance` from `center` along `back`, upright; focal: in image heights.
StartView Facing(
    const Vec3<float>& center, Vec3<float> back, Vec3<float> up, float distance, float focal) {
  const Vec3<float> forward = -math::Normalize(back);
  StartView view;
  Camera& c = view.camera;
  c.width = c.height = kSide;
  c.fx = c.fy = focal * kSide;
  c.cx = c.cy = 0.5f * kSide;
  c = Looking(c, center - forward * distance, forward, up);
  view.center = {center.x, center.y, center.z};
  view.up = {up.x, up.y, up.z};
  return view;
}

// The `share` quantile of `value` over the points, of which there must be at least one.
template <class Value>
float Quantile(const std::vector<Vec3<float>>& points, float share, const Value& value) {
  std::vector<float> values(points.size());
  std::transform(points.begin(), points.end(), values.begin(), value);
  const auto nth = values.begin() + std::ptrdiff_t(share * float(values.size() - 1));
  std::nth_element(values.begin(), nth, values.end());
  return *nth;
}

// Midpoint of the quantiles `share` and 1 - `share` of each coordinate.
Vec3<float> Middle(const std::vector<Vec3<float>>& points, float share) {
  const auto between = [&](float Vec3<float>::*axis) {
    const auto value = [axis](const Vec3<float>& p) { return p.*axis; };
    return (Quantile(points, share, value) + Quantile(points, 1 - share, value)) / 2;
  };
  return {between(&Vec3<float>::x), between(&Vec3<float>::y), between(&Vec3<float>::z)};
}

float Distance(const Vec3<float>& a, const Vec3<float>& b) {
  return std::sqrt(math::Dot(a - b, a - b));
}

}  // namespace

StartView BeforeHead(const std::vector<float>& vertices, const std::array<float, 3>& root) {
  const HeadPlace head = PlaceOfHead(vertices, root);
  return Facing(head.center,
                head.world_from_head * Vec3<float>{0, 0, 1},
                head.world_from_head * Vec3<float>{0, 1, 0},
                kPortraitFocal * head.extent / kPortraitShare,
                kPortraitFocal);
}

StartView AtCamera(const std::vector<Camera>& cameras) {
  Vec3<float> up{0, 0, 0};
  for (const Camera& c : cameras) up += {-c.rotation[3], -c.rotation[4], -c.rotation[5]};
  if (math::Dot(up, up) < 1e-6f) up = {0, -1, 0};
  up = math::Normalize(up);
  return {cameras[0], FocusPoint(cameras), {up.x, up.y, up.z}};
}

StartView BeforeSplats(const std::string& file, const Gaussians& gaussians) {
  const float min = math::Logit(kMinAlpha);
  std::vector<Vec3<float>> points;
  for (size_t i = 0; i < gaussians.size(); ++i) {
    const float* p = gaussians.at(kPosition, i);
    const bool finite = std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]);
    if (finite && *gaussians.at(kOpacityLogit, i) >= min) points.push_back({p[0], p[1], p[2]});
  }
  if (points.empty()) throw Error(file, "vertex", "no splat is visible");
  Vec3<float> center = Middle(points, 0.5f);
  const auto from_center = [&](const Vec3<float>& p) { return Distance(p, center); };
  const float max = kFarthestOfHalf * Quantile(points, 0.5f, from_center);
  std::erase_if(points, [&](const Vec3<float>& p) { return Distance(p, center) > max; });
  center = Middle(points, kMax);
  const float reach = Quantile(points, kMax, from_center);
  const float radius = reach > 0 ? reach : 1;
  StartView view =
      Facing(center, {0, 0, -1}, {0, -1, 0}, 2 * kSceneFocal * kSceneMargin * radius, kSceneFocal);
  view.camera.near_plane *= SmallUnit(radius);
  return view;
}

}  // namespace cosplat::viewer
