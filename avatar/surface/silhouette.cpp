#include "avatar/surface/silhouette.h"

#include <algorithm>
#include <cmath>

namespace cosplat {
namespace {

math::Vec3<float> Vertex(const std::vector<float>& vertices, int32_t v) {
  return math::ToVec3(&vertices[3 * size_t(v)]);
}

float Cross(const ImagePoint& a, const ImagePoint& b, float x, float y) {
  return (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x);
}

// Calls on_pixel(pixel, twice the signed areas opposite to the corners) for each pixel whose centre
// the triangle covers.
template <class OnPixel>
void ForPixels(const std::array<ImagePoint, 3>& t, int width, int height, const OnPixel& on_pixel) {
  const auto clamp = [](float v, int limit) { return int(std::clamp(v, 0.0f, float(limit))); };
  const int x0 = clamp(std::floor(std::min({t[0].x, t[1].x, t[2].x})), width);
  const int x1 = clamp(std::ceil(std::max({t[0].x, t[1].x, t[2].x})), width);
  const int y0 = clamp(std::floor(std::min({t[0].y, t[1].y, t[2].y})), height);
  const int y1 = clamp(std::ceil(std::max({t[0].y, t[1].y, t[2].y})), height);
  for (int y = y0; y < y1; ++y)
    for (int x = x0; x < x1; ++x) {
      const float px = x + 0.5f, py = y + 0.5f;
      const float a = Cross(t[1], t[2], px, py), b = Cross(t[2], t[0], px, py),
                  c = Cross(t[0], t[1], px, py);
      if ((a >= 0 && b >= 0 && c >= 0) || (a <= 0 && b <= 0 && c <= 0))
        on_pixel(size_t(y) * width + x, std::array<float, 3>{a, b, c});
    }
}

// Calls on_face(face, its corners) for those that are before the camera.
template <class OnFace>
void ForFaces(const std::vector<float>& vertices,
              const std::vector<std::array<int32_t, 3>>& faces,
              const Camera& camera,
              const OnFace& on_face) {
  for (size_t f = 0; f < faces.size(); ++f) {
    std::array<ImagePoint, 3> t;
    for (int k = 0; k < 3; ++k) t[k] = Project(camera, Vertex(vertices, faces[f][k]));
    if (std::min({t[0].depth, t[1].depth, t[2].depth}) > 0) on_face(f, t);
  }
}

// The box of points, px.
struct Box {
  float x0 = 1e9f, x1 = -1e9f, y0 = 1e9f, y1 = -1e9f;

  void Add(const ImagePoint& p) {
    x0 = std::min(x0, p.x), x1 = std::max(x1, p.x);
    y0 = std::min(y0, p.y), y1 = std::max(y1, p.y);
  }
  // Of its longer side, at each of its sides.
  Crop WithRoom(float share, const Camera& camera) const {
    const float room = share * std::max(x1 - x0, y1 - y0);
    const auto clamp = [](float v, int limit) { return int(std::clamp(v, 0.0f, float(limit))); };
    const int left = clamp(x0 - room, camera.width), right = clamp(x1 + room, camera.width);
    const int top = clamp(y0 - room, camera.height), bottom = clamp(y1 + room, camera.height);
    const Crop crop{left, top, right - left, bottom - top};
    return crop.empty() ? Crop{} : crop;
  }
};

}  // namespace

ImagePoint Project(const Camera& camera, const math::Vec3<float>& point) {
  std::array<float, 3> p;
  for (size_t r = 0; r < 3; ++r)
    p[r] = math::Dot(math::ToVec3(&camera.rotation[3 * r]), point) + camera.translation[r];
  return {camera.fx * p[0] / p[2] + camera.cx, camera.fy * p[1] / p[2] + camera.cy, p[2]};
}

std::vector<uint8_t> MeshSilhouette(const std::vector<float>& vertices,
                                    const std::vector<std::array<int32_t, 3>>& faces,
                                    const Camera& camera) {
  std::vector<uint8_t> mask(size_t(camera.width) * camera.height, 0);
  ForFaces(vertices, faces, camera, [&](size_t, const std::array<ImagePoint, 3>& corners) {
    ForPixels(
        corners, camera.width, camera.height, [&](size_t pixel, const auto&) { mask[pixel] = 1; });
  });
  return mask;
}

std::vector<MeshPixel> DrawMesh(const std::vector<float>& vertices,
                                const std::vector<std::array<int32_t, 3>>& faces,
                                const Camera& camera) {
  std::vector<MeshPixel> image(size_t(camera.width) * camera.height);
  ForFaces(vertices, faces, camera, [&](size_t f, const std::array<ImagePoint, 3>& corners) {
    ForPixels(
        corners, camera.width, camera.height, [&](size_t pixel, const std::array<float, 3>& areas) {
          // Perspective: what is linear in the image is 1 / depth.
          std::array<float, 3> w;
          for (int k = 0; k < 3; ++k) w[k] = areas[k] / corners[k].depth;
          const float sum = w[0] + w[1] + w[2];
          if (sum == 0) return;  // seen edge-on
          const float depth = (areas[0] + areas[1] + areas[2]) / sum;
          MeshPixel& shown = image[pixel];
          if (shown.face < 0 || depth < shown.depth)
            shown = {int32_t(f), w[0] / sum, w[1] / sum, depth};
        });
  });
  return image;
}

int ChinRow(const std::vector<float>& vertices, const FlameModel& flame, const Camera& camera) {
  constexpr size_t kJaw = 2;
  constexpr float kFollows = 0.5f;  // least skinning weight
  float row = 0;
  for (int v = 0; v < flame.vertex_count; ++v) {
    if (flame.skinning_weights[kFlameJoints * size_t(v) + kJaw] < kFollows) continue;
    const ImagePoint p = Project(camera, Vertex(vertices, v));
    if (p.depth > 0) row = std::max(row, p.y);
  }
  return std::min(int(std::ceil(row)), camera.height);
}

Crop HeadBox(const std::vector<float>& vertices, const FlameModel& flame, const Camera& camera) {
  constexpr float kRoom = 0.2f;
  const float chin = float(ChinRow(vertices, flame, camera));
  Box box;
  for (int v = 0; v < flame.vertex_count; ++v) {
    const ImagePoint p = Project(camera, Vertex(vertices, v));
    if (p.depth > 0 && p.y <= chin) box.Add(p);
  }
  return box.WithRoom(kRoom, camera);
}

Crop MouthBox(const std::vector<float>& vertices,
              const std::vector<float>& canonical_vertices,
              const MeshTopology& topology,
              int head_vertices,
              const Camera& camera) {
  const auto mean_height = [&](const std::vector<int32_t>& loop) {
    double sum = 0;
    for (const int32_t v : loop) sum += canonical_vertices[3 * size_t(v) + 1];
    return sum / double(loop.size());
  };
  std::vector<std::vector<int32_t>> loops = topology.boundary_loops;
  std::erase_if(loops, [&](const auto& loop) { return loop[0] >= head_vertices; });
  if (loops.size() < 2) return {};
  const std::vector<int32_t>& mouth =
      *std::max_element(loops.begin(), loops.end(), [&](const auto& a, const auto& b) {
        return mean_height(a) < mean_height(b);
      });
  Box box;
  for (const int32_t v : mouth) {
    const ImagePoint p = Project(camera, Vertex(vertices, v));
    if (!(p.depth > 0)) return {};
    box.Add(p);
  }
  return box.WithRoom(0.5f, camera);
}

}  // namespace cosplat
