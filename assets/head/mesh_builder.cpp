#include "assets/head/mesh_builder.h"

#include <tbb/parallel_for.h>

#include <algorithm>

namespace cosplat::procedural {
namespace {

// Relaxation pulls vertices towards larger values: nose and chin have the highest curvature.
float WantedDensity(const Vec& p) {
  return 1 + 5 * Bell(Length(p - Vec{0, -0.010f, 0.076f}), 0.013f) +
         1.5f * Bell(Length(p - Vec{0, -0.074f, 0.050f}), 0.022f);
}

}  // namespace

int MeshBuilder::AddVertex(const Vec& position, const VertexLabel& label, bool free) {
  mesh.positions.push_back(position);
  mesh.labels.push_back(label);
  free_.push_back(free);
  return int(mesh.positions.size()) - 1;
}

void MeshBuilder::AddQuad(int a, int b, int c, int d, bool flip) {
  if (flip) {
    AddTriangle(a, b, d);
    AddTriangle(b, c, d);
  } else {
    AddTriangle(a, b, c);
    AddTriangle(a, c, d);
  }
}

void MeshBuilder::JoinLoops(const std::vector<int>& outer, const std::vector<int>& inner) {
  const size_t n = outer.size();
  for (size_t k = 0; k < n; ++k) {
    const size_t next = (k + 1) % n;
    AddQuad(outer[k], outer[next], inner[next], inner[k], (k / (n / 4)) % 2 == 1);
  }
}

void MeshBuilder::CloseLoop(const std::vector<int>& loop, int center) {
  for (size_t k = 0; k < loop.size(); ++k)
    AddTriangle(loop[k], loop[(k + 1) % loop.size()], center);
}

std::vector<std::vector<int>> MeshBuilder::AddSkinRings(const std::vector<int>& outer,
                                                        const std::vector<Vec>& inner_positions,
                                                        int count) {
  std::vector<std::vector<int>> rings;
  const std::vector<int>* previous = &outer;
  for (int r = 1; r <= count; ++r) {
    std::vector<int> ring;
    const float t = float(r) / (count + 1);
    for (size_t k = 0; k < outer.size(); ++k) {
      const Vec from = mesh.positions[outer[k]];
      const Vec p = from + t * (inner_positions[k] - from);
      ring.push_back(AddVertex(ProjectToHead(p), VertexLabel{}, true));
    }
    JoinLoops(*previous, ring);
    rings.push_back(std::move(ring));
    previous = &rings.back();
  }
  return rings;
}

void MeshBuilder::Relax(int iterations) {
  const size_t n = mesh.positions.size();
  std::vector<std::vector<int>> neighbours(n);
  for (const auto& f : mesh.faces)
    for (int c = 0; c < 3; ++c) neighbours[f[c]].push_back(f[(c + 1) % 3]);
  std::vector<Vec> next = mesh.positions;
  for (int i = 0; i < iterations; ++i) {
    tbb::parallel_for(size_t(0), n, [&](size_t v) {
      if (!free_[v]) return;
      Vec mean{};
      float total = 0;
      for (int w : neighbours[v]) {
        const float weight = WantedDensity(mesh.positions[w]);
        mean += weight * mesh.positions[w];
        total += weight;
      }
      mean = mean * (1 / total);
      const Vec p = mesh.positions[v];
      const Vec normal = Normalize(HeadGradient(p));
      const Vec shift = mean - p;
      next[v] = ProjectToHead(p + 0.5f * (shift - normal * Dot(normal, shift)));
    });
    mesh.positions.swap(next);
  }
}

}  // namespace cosplat::procedural
