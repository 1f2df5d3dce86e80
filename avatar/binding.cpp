#include "avatar/binding.h"

#include <string>

#include "avatar/parallel_for.h"
#include "splat/base/error.h"

namespace cosplat {
namespace {

using math::Quat;
using math::Three;
using math::Vec3;
using Local = math::LocalGaussian<float>;
using Posed = math::PosedGaussian<float>;
using Corners = Three<SurfaceVertex>;

Vec3<float> Load3(const float* p) { return {p[0], p[1], p[2]}; }
Quat<float> Load4(const float* p) { return {p[0], p[1], p[2], p[3]}; }
void Store3(const Vec3<float>& v, float* p) {
  p[0] = v.x;
  p[1] = v.y;
  p[2] = v.z;
}
void Store4(const Quat<float>& q, float* p) {
  p[0] = q.w;
  p[1] = q.x;
  p[2] = q.y;
  p[3] = q.z;
}

void CheckSize(const char* field, size_t found, size_t expected) {
  if (found != expected)
    throw Error(
        "avatar",
        field,
        std::to_string(found) + " numbers where " + std::to_string(expected) + " are expected");
}

void CheckModel(const Gaussians& gaussians, const Embedding& embedding, const Surface& surface) {
  const size_t n = gaussians.size();
  const auto& values = gaussians.values;
  CheckSize("position", values[kPosition].size(), 3 * n);
  CheckSize("rotation", values[kRotation].size(), 4 * n);
  CheckSize("scale_log", values[kScaleLog].size(), 3 * n);
  CheckSize("triangle", embedding.triangle.size(), n);
  CheckSize("barycentric", embedding.barycentric.size(), n);
  for (size_t i = 0; i < n; ++i)
    if (size_t(embedding.triangle[i]) >= surface.faces().size())
      throw Error(
          "avatar",
          "triangle[" + std::to_string(i) + "]",
          std::to_string(embedding.triangle[i]) + " of " + std::to_string(surface.faces().size()));
}

Local LoadLocal(const Gaussians& gaussians, const Embedding& embedding, size_t i) {
  const auto& values = gaussians.values;
  return {embedding.barycentric[i][0],
          embedding.barycentric[i][1],
          Load3(&values[kPosition][3 * i]),
          Load4(&values[kRotation][4 * i]),
          Load3(&values[kScaleLog][3 * i])};
}

struct Triangle {
  Corners posed;
  Three<float> canonical_area;
};

Triangle LoadTriangle(const Surface& surface, size_t face) {
  Triangle t;
  for (int c = 0; c < 3; ++c) {
    const int32_t v = surface.faces()[face][c];
    t.posed[c] = surface.vertices()[v];
    t.canonical_area[c] = surface.canonical()[v].area;
  }
  return t;
}

Posed LoadAdjoint(const PosedGaussians& d, size_t i) {
  Posed p;
  p.position = Load3(&d.position[3 * i]);
  p.rotation = Load4(&d.rotation[4 * i]);
  p.scale_log = Load3(&d.scale_log[3 * i]);
  p.frame = d.frame.empty() ? Quat<float>{0, 0, 0, 0} : Load4(&d.frame[4 * i]);
  return p;
}

void BackwardOne(const Gaussians& gaussians,
                 const Embedding& embedding,
                 const Triangle& triangle,
                 const PosedGaussians& d_posed,
                 size_t i,
                 Gaussians& d_gaussians,
                 Corners* d_corners) {
  Local d;
  math::EmbedVjp(triangle.posed,
                 triangle.canonical_area,
                 LoadLocal(gaussians, embedding, i),
                 LoadAdjoint(d_posed, i),
                 d,
                 d_corners);
  Store3(d.offset, &d_gaussians.values[kPosition][3 * i]);
  Store4(d.rotation, &d_gaussians.values[kRotation][4 * i]);
  Store3(d.scale_log, &d_gaussians.values[kScaleLog][3 * i]);
}

// Gaussians of each face, ascending: index[begin[f] .. begin[f + 1]).
struct FaceLists {
  std::vector<uint32_t> begin;
  std::vector<uint32_t> index;
};

FaceLists GroupByFace(const std::vector<int32_t>& triangle, size_t face_count) {
  FaceLists lists;
  lists.begin.assign(face_count + 1, 0);
  lists.index.resize(triangle.size());
  for (int32_t f : triangle) ++lists.begin[f + 1];
  for (size_t f = 0; f < face_count; ++f) lists.begin[f + 1] += lists.begin[f];
  std::vector<uint32_t> next(lists.begin.begin(), lists.begin.end() - 1);
  for (size_t i = 0; i < triangle.size(); ++i) lists.index[next[triangle[i]]++] = uint32_t(i);
  return lists;
}

// Adds what the faces around vertex v got for it, in the order of the faces.
SurfaceVertex GatherVertex(const Surface& surface,
                           const std::vector<Corners>& d_corners,
                           size_t v) {
  const MeshTopology& topology = surface.topology();
  SurfaceVertex sum{};
  for (int32_t k = topology.vertex_face_begin[v]; k < topology.vertex_face_begin[v + 1]; ++k) {
    const int32_t f = topology.vertex_faces[k];
    const SurfaceVertex& d = d_corners[f][CornerOf(surface.faces()[f], v)];
    sum.position += d.position;
    sum.normal += d.normal;
    sum.rotation = sum.rotation + d.rotation;
    sum.area += d.area;
  }
  return sum;
}

}  // namespace

void PosedGaussians::Resize(size_t n) {
  position.resize(3 * n);
  rotation.resize(4 * n);
  scale_log.resize(3 * n);
  frame.resize(4 * n);
}

void Bind(const Gaussians& gaussians,
          const Embedding& embedding,
          const Surface& surface,
          PosedGaussians& out) {
  CheckModel(gaussians, embedding, surface);
  out.Resize(gaussians.size());
  ParallelFor(gaussians.size(), [&](size_t i) {
    const Triangle t = LoadTriangle(surface, embedding.triangle[i]);
    const Posed p = math::Embed(t.posed, t.canonical_area, LoadLocal(gaussians, embedding, i));
    Store3(p.position, &out.position[3 * i]);
    Store4(p.rotation, &out.rotation[4 * i]);
    Store3(p.scale_log, &out.scale_log[3 * i]);
    Store4(p.frame, &out.frame[4 * i]);
  });
}

void BindBackward(const Gaussians& gaussians,
                  const Embedding& embedding,
                  const Surface& surface,
                  const PosedGaussians& d_posed,
                  Gaussians& d_gaussians,
                  std::vector<float>* d_vertices) {
  CheckModel(gaussians, embedding, surface);
  const size_t n = gaussians.size();
  CheckSize("d_position", d_posed.position.size(), 3 * n);
  CheckSize("d_rotation", d_posed.rotation.size(), 4 * n);
  CheckSize("d_scale_log", d_posed.scale_log.size(), 3 * n);
  if (!d_posed.frame.empty()) CheckSize("d_frame", d_posed.frame.size(), 4 * n);
  d_gaussians.values[kPosition].resize(3 * n);
  d_gaussians.values[kRotation].resize(4 * n);
  d_gaussians.values[kScaleLog].resize(3 * n);
  if (!d_vertices) {
    ParallelFor(n, [&](size_t i) {
      const Triangle t = LoadTriangle(surface, embedding.triangle[i]);
      BackwardOne(gaussians, embedding, t, d_posed, i, d_gaussians, nullptr);
    });
    return;
  }
  // Per face in the order of its Gaussians, then per vertex in the order of its faces.
  const FaceLists lists = GroupByFace(embedding.triangle, surface.faces().size());
  std::vector<Corners> d_corners(surface.faces().size());
  ParallelFor(d_corners.size(), [&](size_t f) {
    if (lists.begin[f] == lists.begin[f + 1]) return;
    const Triangle t = LoadTriangle(surface, f);
    for (uint32_t k = lists.begin[f]; k < lists.begin[f + 1]; ++k)
      BackwardOne(gaussians, embedding, t, d_posed, lists.index[k], d_gaussians, &d_corners[f]);
  });
  Buffer<SurfaceVertex> d_surface(surface.vertex_count());
  ParallelFor(d_surface.size(),
              [&](size_t v) { d_surface[v] = GatherVertex(surface, d_corners, v); });
  surface.Backward(d_surface, *d_vertices);
}

}  // namespace cosplat
