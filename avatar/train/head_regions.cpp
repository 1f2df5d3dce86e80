#include "avatar/train/head_regions.h"

#include <algorithm>
#include <cmath>

namespace cosplat {
namespace {

using math::Vec3;

// In units of HeadRegions::unit. The scalp is above a plane from over the forehead, above the eyes,
// to behind the jaw's joint; above the nape; and neither before nor beside the ears.
constexpr float kForehead = 0.9f, kBehindJaw = 0.25f;
constexpr float kNape = 0.55f;  // below the jaw's joint
constexpr float kEarTop = 0.3f, kEarBack = 0.3f;
constexpr float kChin = 1.3f;       // below the eyes
constexpr float kFaceDepth = 0.4f;  // behind the eyes

}  // namespace

HeadRegions FindHeadRegions(const FlameModel& flame, const CanonicalMesh& mesh) {
  HeadRegions regions;
  regions.head_vertices = size_t(flame.vertex_count);
  for (size_t v = 0; v < mesh.vertices.size() / 3; ++v)
    regions.rest.push_back(math::ToVec3(&mesh.vertices[3 * v]));
  const auto joint = [&](int j) {
    Vec3<float> sum{0, 0, 0};
    for (int v = 0; v < flame.vertex_count; ++v)
      sum += regions.rest[size_t(v)] * flame.joint_regressor[size_t(j * flame.vertex_count + v)];
    return sum;
  };
  const Vec3<float> eyes = (joint(3) + joint(4)) * 0.5f, jaw = joint(2);
  const float unit = std::hypot(eyes.y - jaw.y, eyes.z - jaw.z);
  regions.unit = unit;
  regions.eye_height = eyes.y;
  // The plane's trace in the middle of the head, (y, z), and its normal.
  const float y = jaw.y, z = jaw.z - kBehindJaw * unit;
  const float up = eyes.z - z, forward = eyes.y + kForehead * unit - y;
  const float length = unit * std::hypot(up, forward);
  for (size_t v = 0; v < regions.rest.size(); ++v) {
    const Vec3<float>& p = regions.rest[v];
    float within =
        std::min(((p.y - y) * up - (p.z - z) * forward) / length, (p.y - jaw.y) / unit + kNape);
    const bool at_ears = p.y < eyes.y + kEarTop * unit && p.z > jaw.z - kEarBack * unit;
    if (at_ears || regions.IsBust(v)) within = std::min(within, 0.0f);
    HeadPart part = HeadPart::kSides;
    if (regions.IsBust(v) || p.y < eyes.y - kChin * unit)
      part = HeadPart::kBody;
    else if (within > 0 && p.y > eyes.y)
      part = HeadPart::kScalp;
    else if (within <= 0 && p.z > eyes.z - kFaceDepth * unit)
      part = HeadPart::kFace;
    regions.within_scalp.push_back(within);
    regions.part.push_back(part);
  }
  return regions;
}

}  // namespace cosplat
