// Small meshes with known geometry.
#pragma once

#include <cmath>
#include <filesystem>
#include <functional>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "avatar/model/avatar_model.h"
#include "avatar/surface/surface.h"
#include "splat/base/npz.h"

namespace cosplat::test {

// n x n squares over [0, size]^2, each cut along one of its diagonals at random; inner vertices
// moved by up to `jitter` squares. `lift` maps the flat (x, y) to space.
inline CanonicalMesh SheetMesh(
    int n,
    float size = 1,
    float jitter_size = 0.25f,
    unsigned seed = 1,
    const std::function<std::array<float, 3>(float, float)>& lift = nullptr) {
  std::mt19937 rng(seed);
  std::uniform_real_distribution<float> jitter(-jitter_size, jitter_size);
  CanonicalMesh mesh;
  const float step = size / float(n);
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) {
      const bool inner = i > 0 && j > 0 && i < n && j < n;
      const bool moved = inner && jitter_size > 0;
      const float x = (float(i) + (moved ? jitter(rng) : 0)) * step;
      const float y = (float(j) + (moved ? jitter(rng) : 0)) * step;
      const auto p = lift ? lift(x, y) : std::array<float, 3>{x, y, 0};
      mesh.vertices.insert(mesh.vertices.end(), p.begin(), p.end());
    }
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const int a = j * (n + 1) + i, b = a + 1, c = a + n + 1, d = c + 1;
      if (rng() % 2) {
        mesh.faces.push_back({a, b, d});
        mesh.faces.push_back({a, d, c});
      } else {
        mesh.faces.push_back({a, b, c});
        mesh.faces.push_back({b, d, c});
      }
    }
  return mesh;
}

// A closed octahedron split `levels` times and pushed onto the sphere of this radius and centre.
inline CanonicalMesh SphereMesh(int levels, float radius = 1, std::array<float, 3> centre = {}) {
  CanonicalMesh mesh;
  mesh.vertices = {1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 1, 0, 0, -1};
  mesh.faces = {
      {0, 2, 4}, {2, 1, 4}, {1, 3, 4}, {3, 0, 4}, {2, 0, 5}, {1, 2, 5}, {3, 1, 5}, {0, 3, 5}};
  for (int level = 0; level < levels; ++level) {
    std::vector<std::array<int32_t, 3>> finer;
    std::map<std::pair<int, int>, int> middle;
    const auto split = [&](int a, int b) {
      const auto key = std::minmax(a, b);
      const auto found = middle.find(key);
      if (found != middle.end()) return found->second;
      float p[3], length = 0;
      for (int k = 0; k < 3; ++k) {
        p[k] = mesh.vertices[3 * a + k] + mesh.vertices[3 * b + k];
        length += p[k] * p[k];
      }
      for (float x : p) mesh.vertices.push_back(x / std::sqrt(length));
      return middle[key] = int(mesh.vertices.size() / 3) - 1;
    };
    for (const auto& f : mesh.faces) {
      const int ab = split(f[0], f[1]), bc = split(f[1], f[2]), ca = split(f[2], f[0]);
      finer.insert(finer.end(), {{f[0], ab, ca}, {ab, f[1], bc}, {ca, bc, f[2]}, {ab, bc, ca}});
    }
    mesh.faces = finer;
  }
  for (size_t i = 0; i < mesh.vertices.size(); ++i)
    mesh.vertices[i] = mesh.vertices[i] * radius + centre[i % 3];
  return mesh;
}

// `b` beside `a`, unconnected.
inline CanonicalMesh Joined(CanonicalMesh a, const CanonicalMesh& b) {
  const int32_t offset = int32_t(a.vertices.size() / 3);
  a.vertices.insert(a.vertices.end(), b.vertices.begin(), b.vertices.end());
  for (const auto& f : b.faces) a.faces.push_back({f[0] + offset, f[1] + offset, f[2] + offset});
  return a;
}

inline CanonicalMesh Scaled(CanonicalMesh mesh, float factor) {
  for (float& x : mesh.vertices) x *= factor;
  return mesh;
}

// Vertices turned about `axis` (unit) by `angle` radians.
inline std::vector<float> Turned(const std::vector<float>& vertices,
                                 std::array<float, 3> axis,
                                 double angle) {
  const math::Quat<double> q{std::cos(angle / 2),
                             std::sin(angle / 2) * axis[0],
                             std::sin(angle / 2) * axis[1],
                             std::sin(angle / 2) * axis[2]};
  const auto r = math::RotationOf(q);
  std::vector<float> out(vertices.size());
  for (size_t v = 0; v < vertices.size(); v += 3) {
    const auto p = r * math::Vec3<double>{vertices[v], vertices[v + 1], vertices[v + 2]};
    out[v] = float(p.x);
    out[v + 1] = float(p.y);
    out[v + 2] = float(p.z);
  }
  return out;
}

inline math::Vec3<double> VertexOf(const CanonicalMesh& mesh, int32_t v) {
  return {mesh.vertices[3 * v], mesh.vertices[3 * v + 1], mesh.vertices[3 * v + 2]};
}
inline math::Vec3<double> PointOf(const CanonicalMesh& mesh, const SurfacePoint& p) {
  const auto& f = mesh.faces[p.triangle];
  const double u = p.barycentric[0], v = p.barycentric[1];
  return VertexOf(mesh, f[0]) * u + VertexOf(mesh, f[1]) * v + VertexOf(mesh, f[2]) * (1 - u - v);
}
inline double Distance(const math::Vec3<double>& a, const math::Vec3<double>& b) {
  return math::Length(a - b);
}

// The (du, dv) on triangle `face` of a step in space, projected on the triangle's plane.
inline std::array<float, 2> StepOf(const CanonicalMesh& mesh,
                                   int32_t face,
                                   const math::Vec3<double>& step) {
  const auto& f = mesh.faces[face];
  const auto a = VertexOf(mesh, f[0]) - VertexOf(mesh, f[2]);
  const auto b = VertexOf(mesh, f[1]) - VertexOf(mesh, f[2]);
  const double aa = math::Dot(a, a), ab = math::Dot(a, b), bb = math::Dot(b, b);
  const double as = math::Dot(a, step), bs = math::Dot(b, step), det = aa * bb - ab * ab;
  return {float((bb * as - ab * bs) / det), float((aa * bs - ab * as) / det)};
}

// FLAME's template, where the data is: its file, or nothing.
inline std::string FlameFile() {
  const std::string path =
      std::string(COSPLAT_SOURCE_DIR) + "/../shared/data/flame/flame2023_open_noexpr.npz";
  return std::filesystem::exists(path) ? path : std::string();
}
inline CanonicalMesh FlameMesh() {
  const Npz file = Npz::Read(FlameFile());
  const NpyArray &vertices = file.Get("v_template"), &faces = file.Get("faces");
  CanonicalMesh mesh;
  mesh.vertices.assign(vertices.values.begin(), vertices.values.end());
  for (size_t i = 0; i < faces.size(); i += 3)
    mesh.faces.push_back(
        {int32_t(faces.values[i]), int32_t(faces.values[i + 1]), int32_t(faces.values[i + 2])});
  return mesh;
}

// n Gaussians on random triangles with random offsets inside or just outside them.
inline AvatarModel RandomAvatar(const CanonicalMesh& mesh, size_t n, unsigned seed) {
  std::mt19937 rng(seed);
  std::normal_distribution<float> normal;
  std::uniform_real_distribution<float> uniform;
  AvatarModel model;
  model.mesh = mesh;
  auto& values = model.gaussians.values;
  values[kOpacityLogit].resize(n);
  for (size_t i = 0; i < n; ++i) {
    model.embedding.triangle.push_back(int32_t(rng() % mesh.faces.size()));
    const float s = std::sqrt(uniform(rng)), t = uniform(rng);
    model.embedding.barycentric.push_back({1 - s, s * t});
    for (float scale : {0.2f, 0.2f, 0.05f}) values[kPosition].push_back(scale * normal(rng));
    for (int k = 0; k < 4; ++k) values[kRotation].push_back(normal(rng));
    for (int k = 0; k < 3; ++k) values[kScaleLog].push_back(-3 + 0.5f * normal(rng));
  }
  return model;
}

}  // namespace cosplat::test
