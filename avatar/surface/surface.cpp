#include "avatar/surface/surface.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "avatar/surface/kernels/surface.h"
#include "avatar/surface/parallel_for.h"
#include "avatar/surface/surface_packs.h"
#include "splat/base/error.h"

namespace cosplat {
namespace {

using math::Vec3;

// Checked here because the packs read vertices as rows of floats.
static_assert(sizeof(SurfaceVertex) == kSurfaceVertexFloats * sizeof(float));

// Square root of the total area of FLAME 2023's template (5,023 vertices, 9,976 faces): measured
// as sqrt(0.181554 m^2) on the openly licensed release.
constexpr double kFlameTemplateSize = 0.426091;
constexpr double kPublishedEnlargement = 4;

void CheckVertices(const std::vector<float>& vertices, size_t count) {
  if (vertices.size() != 3 * count)
    throw Error(
        "surface",
        "vertices",
        std::to_string(vertices.size() / 3) + " vertices for a mesh of " + std::to_string(count));
  for (size_t i = 0; i < vertices.size(); ++i)
    if (!std::isfinite(vertices[i]))
      throw Error("surface",
                  "vertices[" + std::to_string(i / 3) + "]",
                  "coordinate is " + std::to_string(vertices[i]));
}

}  // namespace

Surface::Surface(const CanonicalMesh& mesh)
    : faces_(mesh.faces),
      topology_(BuildTopology("canonical mesh", mesh.faces, int(mesh.vertices.size() / 3))),
      corner_places_(3 * mesh.faces.size()),
      canonical_frames_(mesh.faces.size()),
      vertices_(mesh.vertices.size() / 3),
      posed_faces_(kPosedFaceFloats * (mesh.faces.size() + 1)),
      sums_(kVertexSumFloats * vertices_.size()),
      signs_(topology_.vertex_faces.size()) {
  if (faces_.empty()) throw Error("canonical mesh", "faces", "there are none");
  CheckVertices(mesh.vertices);
  const auto at = [&](int32_t v) {
    return Vec3<float>{mesh.vertices[3 * v], mesh.vertices[3 * v + 1], mesh.vertices[3 * v + 2]};
  };
  for (size_t f = 0; f < faces_.size(); ++f)
    canonical_frames_[f] = math::FaceFrame(at(faces_[f][0]), at(faces_[f][1]), at(faces_[f][2]));
  for (size_t v = 0; v < vertices_.size(); ++v)
    for (int32_t k = topology_.vertex_face_begin[v]; k < topology_.vertex_face_begin[v + 1]; ++k) {
      const size_t f = topology_.vertex_faces[k];
      corner_places_[3 * f + CornerOf(faces_[f].data(), v)] = k;
    }
  Pose(mesh.vertices);
  canonical_ = vertices_;
  canonical_areas_.resize(4 * faces_.size());
  for (size_t f = 0; f < faces_.size(); ++f)
    for (int c = 0; c < 3; ++c) canonical_areas_[4 * f + c] = canonical_[faces_[f][c]].area;
}

SurfaceArrays Surface::Arrays() const {
  SurfaceArrays arrays;
  arrays.face_count = faces_.size();
  arrays.vertex_count = vertices_.size();
  arrays.faces = faces_.data()->data();
  arrays.vertex_face_begin = topology_.vertex_face_begin.data();
  arrays.vertex_faces = topology_.vertex_faces.data();
  arrays.corner_places = corner_places_.data();
  arrays.canonical_frames = canonical_frames_.data()->m;
  arrays.vertices = const_cast<float*>(&vertices_.data()->position.x);
  arrays.posed_faces = const_cast<float*>(posed_faces_.data());
  arrays.sums = const_cast<float*>(sums_.data());
  arrays.signs = const_cast<float*>(signs_.data());
  return arrays;
}

MeshArrays Surface::CanonicalArrays() const {
  MeshArrays arrays;
  arrays.face_count = faces_.size();
  arrays.faces = faces_.data()->data();
  arrays.face_neighbors = topology_.face_neighbors.data()->data();
  arrays.neighbor_edges = topology_.neighbor_edges.data()->data();
  arrays.vertex_face_begin = topology_.vertex_face_begin.data();
  arrays.vertex_faces = topology_.vertex_faces.data();
  arrays.vertices = &canonical_.data()->position.x;
  return arrays;
}

void Surface::CheckVertices(const std::vector<float>& vertices) const {
  cosplat::CheckVertices(vertices, vertices_.size());
}

void Surface::Pose(const std::vector<float>& vertices) {
  CheckVertices(vertices);
  for (size_t v = 0; v < vertices_.size(); ++v)
    vertices_[v].position = {vertices[3 * v], vertices[3 * v + 1], vertices[3 * v + 2]};
  LaunchPoseSurface(Arrays());
}

void Surface::Backward(const Buffer<SurfaceVertex>& d_surface,
                       std::vector<float>& d_vertices) const {
  Buffer<SurfaceVertex> d_sums(vertices_.size());
  Buffer<float> d_corners(9 * faces_.size());
  LaunchPoseSurfaceVjp(
      Arrays(), &d_surface.data()->position.x, &d_sums.data()->position.x, d_corners.data());
  d_vertices.resize(3 * vertices_.size());
  const math::SumCornersKernel sum{
      Arrays(), &d_sums.data()->position.x, d_corners.data(), d_vertices.data()};
  ParallelFor(vertices_.size(), [&](size_t v) { sum.Run(v); });
}

double FaceArea(const CanonicalMesh& mesh, size_t face) {
  Vec3<double> p[3];
  for (int c = 0; c < 3; ++c) {
    const size_t vertex = size_t(mesh.faces[face][c]);
    if (vertex >= mesh.vertices.size() / 3)
      throw Error("canonical mesh",
                  "faces[" + std::to_string(face) + "]",
                  "names vertex " + std::to_string(mesh.faces[face][c]) + " of " +
                      std::to_string(mesh.vertices.size() / 3));
    const float* v = &mesh.vertices[3 * vertex];
    p[c] = {v[0], v[1], v[2]};
  }
  return math::Length(math::AreaVector(p[0], p[1], p[2]));
}

double SurfaceArea(const CanonicalMesh& mesh) {
  double total = 0;
  for (size_t f = 0; f < mesh.faces.size(); ++f) total += FaceArea(mesh, f);
  return total;
}

float MeshUnit(const CanonicalMesh& mesh) {
  return float(std::sqrt(SurfaceArea(mesh)) / (kPublishedEnlargement * kFlameTemplateSize));
}

}  // namespace cosplat
