#include "avatar/surface/silhouette.h"

#include <algorithm>
#include <cmath>

namespace cosplat {
namespace {

struct ScreenPoint {
  float x, y, depth;
};

ScreenPoint Project(const std::vector<float>& vertices, int32_t v, const Camera& c) {
  const float* p = &vertices[3 * size_t(v)];
  float q[3];
  for (int r = 0; r < 3; ++r)
    q[r] = c.rotation[3 * r] * p[0] + c.rotation[3 * r + 1] * p[1] + c.rotation[3 * r + 2] * p[2] +
           c.translation[r];
  return {c.fx * q[0] / q[2] + c.cx, c.fy * q[1] / q[2] + c.cy, q[2]};
}

float Cross(const ScreenPoint& a, const ScreenPoint& b, float x, float y) {
  return (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x);
}

void FillTriangle(const std::array<ScreenPoint, 3>& t,
                  int width,
                  int height,
                  std::vector<uint8_t>& mask) {
  const auto clamp = [](float v, int limit) { return int(std::clamp(v, 0.0f, float(limit))); };
  const int x0 = clamp(std::floor(std::min({t[0].x, t[1].x, t[2].x})), width);
  const int x1 = clamp(std::ceil(std::max({t[0].x, t[1].x, t[2].x})), width);
  const int y0 = clamp(std::floor(std::min({t[0].y, t[1].y, t[2].y})), height);
  const int y1 = clamp(std::ceil(std::max({t[0].y, t[1].y, t[2].y})), height);
  for (int y = y0; y < y1; ++y)
    for (int x = x0; x < x1; ++x) {
      const float px = x + 0.5f, py = y + 0.5f;
      const float a = Cross(t[0], t[1], px, py), b = Cross(t[1], t[2], px, py),
                  c = Cross(t[2], t[0], px, py);
      if ((a >= 0 && b >= 0 && c >= 0) || (a <= 0 && b <= 0 && c <= 0))
        mask[size_t(y) * width + x] = 1;
    }
}

// The box of points, px.
struct Box {
  float x0 = 1e9f, x1 = -1e9f, y0 = 1e9f, y1 = -1e9f;

  void Add(const ScreenPoint& p) {
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

std::vector<uint8_t> MeshSilhouette(const std::vector<float>& vertices,
                                    const std::vector<std::array<int32_t, 3>>& faces,
                                    const Camera& camera) {
  std::vector<uint8_t> mask(size_t(camera.width) * camera.height, 0);
  for (const std::array<int32_t, 3>& face : faces) {
    std::array<ScreenPoint, 3> t;
    for (int k = 0; k < 3; ++k) t[k] = Project(vertices, face[k], camera);
    if (std::min({t[0].depth, t[1].depth, t[2].depth}) > 0)
      FillTriangle(t, camera.width, camera.height, mask);
  }
  return mask;
}

int ChinRow(const std::vector<float>& vertices, const FlameModel& flame, const Camera& camera) {
  constexpr size_t kJaw = 2;
  constexpr float kFollows = 0.5f;  // least skinning weight
  float row = 0;
  for (int v = 0; v < flame.vertex_count; ++v) {
    if (flame.skinning_weights[kFlameJoints * size_t(v) + kJaw] < kFollows) continue;
    const ScreenPoint p = Project(vertices, v, camera);
    if (p.depth > 0) row = std::max(row, p.y);
  }
  return std::min(int(std::ceil(row)), camera.height);
}

Crop HeadBox(const std::vector<float>& vertices, const FlameModel& flame, const Camera& camera) {
  constexpr float kRoom = 0.2f;
  const float chin = float(ChinRow(vertices, flame, camera));
  Box box;
  for (int v = 0; v < flame.vertex_count; ++v) {
    const ScreenPoint p = Project(vertices, v, camera);
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
    const ScreenPoint p = Project(vertices, v, camera);
    if (!(p.depth > 0)) return {};
    box.Add(p);
  }
  return box.WithRoom(0.5f, camera);
}

}  // namespace cosplat
