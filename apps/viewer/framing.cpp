#include <algorithm>
#include <cmath>
#include <string>

#include "apps/viewer/orbit_camera.h"
#include "flame/math/rodrigues.h"
#include "splat/base/error.h"
#include "splat/base/world_frame.h"
#include "splat/config.h"
#include "splat/math/scalar.h"
#include "splat/train/start/initialize.h"

namespace cosplat::viewer {
namespace {

using math::Vec3;

constexpr int kSide = 768;  // image size of generated cameras; px
// Focal lengths in image heights: 28 degrees, a portrait lens, for heads; 45 for scenes.
constexpr float kHeadFocal = 2.0f, kSceneFocal = 1.2f;
constexpr float kHeadShare = 0.7f;  // of the image, filled by a head
// Splats farther from a scene's centre than this multiple of the median distance count as
// surroundings or strays; this share of the others should be in the image.
constexpr float kFarthestOfHalf = 3, kMax = 0.99f;
constexpr float kSceneMargin = 1.1f;

// Camera at `distance` from `center` along `back`, upright; focal: in image heights.
StartView Facing(
    const Vec3<float>& center, Vec3<float> back, Vec3<float> up, float distance, float focal) {
  const Vec3<float> z = -math::Normalize(back);
  const Vec3<float> x = math::Normalize(math::Cross(z, up));
  const Vec3<float> y = math::Cross(z, x);
  const Vec3<float> eye = center - z * distance;
  StartView view;
  Camera& c = view.camera;
  c.width = c.height = kSide;
  c.fx = c.fy = focal * kSide;
  c.cx = c.cy = 0.5f * kSide;
  c.rotation = {x.x, x.y, x.z, y.x, y.y, y.z, z.x, z.y, z.z};
  c.translation = {-math::Dot(x, eye), -math::Dot(y, eye), -math::Dot(z, eye)};
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
  math::Mat3<float> world_from_head;
  const std::array<float, 9> turn = flame_math::Rodrigues(root);
  std::copy(turn.begin(), turn.end(), world_from_head.m);
  Vec3<float> least{1e30f, 1e30f, 1e30f}, most{-1e30f, -1e30f, -1e30f};  // in the head's own axes
  for (size_t i = 0; i + 2 < vertices.size(); i += 3) {
    const Vec3<float> p = math::TransposeTimes(
        world_from_head, Vec3<float>{vertices[i], vertices[i + 1], vertices[i + 2]});
    least = {std::min(least.x, p.x), std::min(least.y, p.y), std::min(least.z, p.z)};
    most = {std::max(most.x, p.x), std::max(most.y, p.y), std::max(most.z, p.z)};
  }
  const float across = std::max(most.x - least.x, most.y - least.y);
  // FLAME's y is up and its face looks along +z.
  return Facing(world_from_head * ((least + most) * 0.5f),
                world_from_head * Vec3<float>{0, 0, 1},
                world_from_head * Vec3<float>{0, 1, 0},
                kHeadFocal * across / kHeadShare,
                kHeadFocal);
}

StartView AtCamera(const std::vector<Camera>& cameras) {
  Vec3<float> up{0, 0, 0};
  for (const Camera& c : cameras) up += {-c.rotation[3], -c.rotation[4], -c.rotation[5]};
  if (math::Dot(up, up) < 1e-6f) up = {0, -1, 0};
  up = math::Normalize(up);
  return {cameras[0], FocusPoint(cameras), {up.x, up.y, up.z}};
}

StartView BeforeSplats(const std::string& file, const Gaussians& gaussians) {
  const float least = math::Logit(kMinAlpha);
  std::vector<Vec3<float>> points;
  for (size_t i = 0; i < gaussians.size(); ++i) {
    const float* p = gaussians.at(kPosition, i);
    const bool finite = std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2]);
    if (finite && *gaussians.at(kOpacityLogit, i) >= least) points.push_back({p[0], p[1], p[2]});
  }
  if (points.empty()) throw Error(file, "vertex", "no splat is visible");
  Vec3<float> center = Middle(points, 0.5f);
  const auto from_center = [&](const Vec3<float>& p) { return Distance(p, center); };
  const float most = kFarthestOfHalf * Quantile(points, 0.5f, from_center);
  std::erase_if(points, [&](const Vec3<float>& p) { return Distance(p, center) > most; });
  center = Middle(points, kMax);
  const float reach = Quantile(points, kMax, from_center);
  const float radius = reach > 0 ? reach : 1;
  StartView view =
      Facing(center, {0, 0, -1}, {0, -1, 0}, 2 * kSceneFocal * kSceneMargin * radius, kSceneFocal);
  view.camera.near_plane *= SmallUnit(radius);
  return view;
}

}  // namespace cosplat::viewer
