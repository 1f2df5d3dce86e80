#include "avatar/train/mesh_in_frame.h"

#include <algorithm>
#include <cmath>

#include "avatar/math/one_euro.h"
#include "splat/media/signed_distance.h"

namespace cosplat {
namespace {

using math::Vec3;

// From these cosines on a surface's colour is taken: not at all, fully.
constexpr float kGrazing = 0.15f, kFacing = 0.45f;
// From these distances from the person's rim on, whose pixels have the background in them, px.
constexpr float kOfRim = 1, kWellWithin = 3;
// What lies so much deeper than the mesh in its pixel is hidden; metres, for a scale of 1.
constexpr float kHidden = 0.005f;

}  // namespace

std::vector<Vec3<float>> NormalsOf(const std::vector<float>& vertices, const Faces& faces) {
  const auto vertex = [&](int32_t v) { return math::ToVec3(&vertices[3 * size_t(v)]); };
  std::vector<Vec3<float>> normals(vertices.size() / 3, Vec3<float>{0, 0, 0});
  for (const std::array<int32_t, 3>& f : faces) {
    const Vec3<float> a = vertex(f[0]);
    const Vec3<float> normal = math::Cross(vertex(f[1]) - a, vertex(f[2]) - a);
    for (const int32_t v : f) normals[size_t(v)] += normal;
  }
  for (Vec3<float>& n : normals) n = n * (1 / std::sqrt(std::max(math::Dot(n, n), 1e-30f)));
  return normals;
}

bool IsIn(const Camera& camera, const ImagePoint& at) {
  return at.depth > 0 && at.x >= 1 && at.y >= 1 && at.x < float(camera.width - 1) &&
         at.y < float(camera.height - 1);
}

size_t PixelOf(const Camera& camera, const ImagePoint& at) {
  return size_t(at.y) * size_t(camera.width) + size_t(at.x);
}

float Facing(const Camera& camera, const Vec3<float>& point, const Vec3<float>& normal) {
  const Vec3<float> to = math::ToVec3(camera.Center()) - point;
  return math::Dot(to, normal) /
         std::sqrt(std::max(math::Dot(to, to) * math::Dot(normal, normal), 1e-30f));
}

FrameOnMesh::FrameOnMesh(const MeshInFrame& seen, const Faces& faces, float scale)
    : frame_(*seen.frame),
      hidden_(kHidden * scale),
      mesh_(DrawMesh(seen.vertices, faces, frame_.camera)) {
  Image8 mask(frame_.target.width, frame_.target.height, 1);
  for (size_t i = 0; i < mask.pixels(); ++i) mask.data[i] = seen.Alpha(i);
  from_person_ = SignedDistance(mask, 128);
}

FrameOnMesh::Sample FrameOnMesh::At(const Vec3<float>& point, const Vec3<float>& normal) const {
  const Camera& camera = frame_.camera;
  const ImagePoint at = Project(camera, point);
  const float facing = Facing(camera, point, normal);
  if (!IsIn(camera, at) || !(facing > kGrazing)) return {};
  const MeshPixel& shown = mesh_[PixelOf(camera, at)];
  const float within = -from_person_.data[PixelOf(camera, at)];
  if (shown.face < 0 || shown.depth < at.depth - hidden_ || !(within > kOfRim)) return {};
  Sample sample;
  sample.weight = math::Ease((facing - kGrazing) / (kFacing - kGrazing)) *
                  math::Ease((within - kOfRim) / (kWellWithin - kOfRim));
  const float left = std::floor(at.x - 0.5f), top = std::floor(at.y - 0.5f);
  const float right_share = at.x - 0.5f - left, low_share = at.y - 0.5f - top;
  for (int k = 0; k < 4; ++k) {
    const bool right = k % 2 != 0, low = k / 2 != 0;
    const float share = (right ? right_share : 1 - right_share) * (low ? low_share : 1 - low_share);
    for (int c = 0; c < 3; ++c)
      sample.color[c] += share * float(frame_.target.at(int(left) + right, int(top) + low, c));
  }
  return sample;
}

}  // namespace cosplat
