#include "apps/viewer/mesh_view.h"

#include <algorithm>
#include <cmath>

#include "splat/config.h"
#include "splat/math/vec.h"

namespace cosplat::viewer {
namespace {

using math::Vec3;

constexpr float kEdgeSamples = 1.1f;  // half an edge's width
constexpr Rgb kEdgeColor{120, 200, 255};
constexpr Rgb kHiddenColor{28, 32, 40};

// A face in the image, in samples.
struct Triangle {
  float x[3], y[3], inverse_z[3];
  float min_x, max_x, min_y, max_y;
  float inverse_area;  // inverse of twice the signed area
  float height[3];     // of each corner over the opposite edge, samples
  Rgb color;
};

bool Project(const Vec3<float> corners[3], const Camera& c, Triangle& t) {
  for (int k = 0; k < 3; ++k) {
    if (!(corners[k].z > c.near_plane)) return false;
    t.inverse_z[k] = 1 / corners[k].z;
    t.x[k] = c.fx * corners[k].x * t.inverse_z[k] + c.cx;
    t.y[k] = c.fy * corners[k].y * t.inverse_z[k] + c.cy;
  }
  t.min_x = std::min({t.x[0], t.x[1], t.x[2]});
  t.max_x = std::max({t.x[0], t.x[1], t.x[2]});
  t.min_y = std::min({t.y[0], t.y[1], t.y[2]});
  t.max_y = std::max({t.y[0], t.y[1], t.y[2]});
  const float area = (t.x[1] - t.x[0]) * (t.y[2] - t.y[0]) - (t.x[2] - t.x[0]) * (t.y[1] - t.y[0]);
  if (!(std::abs(area) > 1e-9f)) return false;
  t.inverse_area = 1 / area;
  for (int k = 0; k < 3; ++k) {
    const int a = (k + 1) % 3, b = (k + 2) % 3;
    t.height[k] = std::abs(area) / std::hypot(t.x[b] - t.x[a], t.y[b] - t.y[a]);
  }
  return t.max_x > 0 && t.max_y > 0 && t.min_x < float(c.width) && t.min_y < float(c.height);
}

void FillRow(const Triangle& t, int y, bool edges_only, SurfaceBuffer& buffer) {
  const float py = float(y) + 0.5f;
  const int begin = std::max(0, int(std::floor(t.min_x)));
  const int end = std::min(buffer.width, int(std::ceil(t.max_x)));
  for (int x = begin; x < end; ++x) {
    const float px = float(x) + 0.5f;
    float weight[3], edge = 1e30f, inverse_z = 0;
    for (int k = 0; k < 3; ++k) {
      const int a = (k + 1) % 3, b = (k + 2) % 3;
      weight[k] = ((t.x[a] - px) * (t.y[b] - py) - (t.x[b] - px) * (t.y[a] - py)) * t.inverse_area;
      inverse_z += weight[k] * t.inverse_z[k];
      edge = std::min(edge, weight[k] * t.height[k]);
    }
    if (weight[0] < 0 || weight[1] < 0 || weight[2] < 0) continue;
    const Rgb& color = !edges_only ? t.color : edge < kEdgeSamples ? kEdgeColor : kHiddenColor;
    buffer.Put(x, y, 1 / inverse_z, color);
  }
}

std::vector<Triangle> ProjectFaces(const std::vector<float>& vertices,
                                   const std::vector<std::array<int32_t, 3>>& faces,
                                   const MeshPaint& paint,
                                   const Camera& c) {
  std::vector<Triangle> triangles;
  triangles.reserve(faces.size());
  for (size_t f = 0; f < faces.size(); ++f) {
    Vec3<float> corners[3];
    for (int k = 0; k < 3; ++k) {
      const float* p = &vertices[3 * size_t(faces[f][size_t(k)])];
      const float* r = c.rotation.data();
      corners[k] = {r[0] * p[0] + r[1] * p[1] + r[2] * p[2] + c.translation[0],
                    r[3] * p[0] + r[4] * p[1] + r[5] * p[2] + c.translation[1],
                    r[6] * p[0] + r[7] * p[1] + r[8] * p[2] + c.translation[2]};
    }
    Triangle t;
    if (!Project(corners, c, t)) continue;
    const Vec3<float> normal =
        math::Normalize(math::Cross(corners[1] - corners[0], corners[2] - corners[0]));
    t.color = Lit(paint.faces[f], {normal.x, normal.y, normal.z});
    triangles.push_back(t);
  }
  return triangles;
}

}  // namespace

void DrawMesh(const std::vector<float>& vertices,
              const std::vector<std::array<int32_t, 3>>& faces,
              const MeshPaint& paint,
              const Camera& camera,
              SurfaceBuffer& buffer) {
  const std::vector<Triangle> triangles =
      ProjectFaces(vertices, faces, paint, SampleCamera(camera));
  ForBands(buffer, [&](int first, int end) {
    for (const Triangle& t : triangles) {
      const int from = std::max(first, int(std::floor(std::max(t.min_y, 0.0f))));
      const int to = std::min(end, int(std::ceil(std::min(t.max_y, float(buffer.height)))));
      for (int y = from; y < to; ++y) FillRow(t, y, paint.edges_only, buffer);
    }
  });
}

std::vector<int> CountPerFace(cosplat::View<const int32_t> triangle, size_t faces) {
  std::vector<int> counts(faces, 0);
  for (const int32_t t : triangle) ++counts[size_t(t)];
  return counts;
}

std::vector<Rgb> CountColors(const std::vector<int>& counts) {
  const int max = counts.empty() ? 0 : *std::max_element(counts.begin(), counts.end());
  std::vector<Rgb> colors;
  colors.reserve(counts.size());
  for (const int count : counts)
    colors.push_back(count > 0 ? ScaleColor(CountPlace(count, max)) : kNoneColor);
  return colors;
}

}  // namespace cosplat::viewer
