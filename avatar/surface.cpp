#include "avatar/surface.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "avatar/embed_packs.h"
#include "avatar/parallel_for.h"
#include "splat/base/error.h"

namespace cosplat {
namespace {

using math::Quat;
using math::Three;
using math::Vec3;

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

std::array<double, 3> KeepInsideTriangle(std::array<double, 3> weights) {
  double sum = 0;
  for (double& w : weights) sum += w = std::max(w, kInsideTriangle);
  for (double& w : weights) w /= sum;
  return weights;
}

Surface::Surface(const CanonicalMesh& mesh)
    : faces_(mesh.faces),
      topology_(BuildTopology("canonical mesh", mesh.faces, int(mesh.vertices.size() / 3))),
      vertex_face_of_corner_(3 * mesh.faces.size()),
      canonical_frames_(mesh.faces.size()),
      vertices_(mesh.vertices.size() / 3),
      face_areas_(mesh.faces.size()),
      face_rotations_(mesh.faces.size()),
      signs_(topology_.vertex_faces.size()),
      vertex_tape_(mesh.vertices.size() / 3) {
  if (faces_.empty()) throw Error("canonical mesh", "faces", "there are none");
  CheckVertices(mesh.vertices, vertices_.size());
  const auto at = [&](int32_t v) {
    return Vec3<float>{mesh.vertices[3 * v], mesh.vertices[3 * v + 1], mesh.vertices[3 * v + 2]};
  };
  for (size_t f = 0; f < faces_.size(); ++f)
    canonical_frames_[f] = math::FaceFrame(at(faces_[f][0]), at(faces_[f][1]), at(faces_[f][2]));
  for (size_t v = 0; v < vertices_.size(); ++v)
    for (int32_t k = topology_.vertex_face_begin[v]; k < topology_.vertex_face_begin[v + 1]; ++k) {
      const size_t f = topology_.vertex_faces[k];
      vertex_face_of_corner_[3 * f + CornerOf(faces_[f], v)] = k;
    }
  Pose(mesh.vertices);
  canonical_ = vertices_;
  canonical_areas_.resize(4 * faces_.size());
  for (size_t f = 0; f < faces_.size(); ++f)
    for (int c = 0; c < 3; ++c) canonical_areas_[4 * f + c] = canonical_[faces_[f][c]].area;
}

Three<Vec3<float>> Surface::Corners(size_t face) const {
  const auto& f = faces_[face];
  return {{vertices_[f[0]].position, vertices_[f[1]].position, vertices_[f[2]].position}};
}

void Surface::Pose(const std::vector<float>& vertices) {
  CheckVertices(vertices, vertices_.size());
  for (size_t v = 0; v < vertices_.size(); ++v)
    vertices_[v].position = {vertices[3 * v], vertices[3 * v + 1], vertices[3 * v + 2]};
  PoseFacesJob job;
  job.count = faces_.size();
  job.faces = faces_.data();
  job.vertices = &vertices_.data()->position.x;
  job.canonical_frames = canonical_frames_.data()->m;
  job.area = &face_areas_.data()->vector.x;
  job.rotation = &face_rotations_.data()->w;
  LaunchPoseFaces(job);
  ParallelFor(vertices_.size(), [&](size_t v) { PoseVertex(v); });
}

// Each rotation is added in the hemisphere of the sum so far, which therefore only grows: face
// rotations cannot cancel at a vertex.
void Surface::PoseVertex(size_t vertex) {
  Vec3<float> normal{0, 0, 0};
  Quat<float> rotation{0, 0, 0, 0};
  float area = 0;
  const int32_t begin = topology_.vertex_face_begin[vertex];
  const int32_t end = topology_.vertex_face_begin[vertex + 1];
  for (int32_t k = begin; k < end; ++k) {
    const int32_t f = topology_.vertex_faces[k];
    const AreaOfFace& face = face_areas_[f];
    const Quat<float>& q = face_rotations_[f];
    const float sign = math::HemisphereSign(rotation, q);
    signs_[k] = sign;
    normal += face.vector;
    rotation = rotation + q * (sign * face.size);
    area += face.size;
  }
  // Areas of a head in metres are near 1e-5: the sum is brought to norm 1 or less before
  // Normalize's floor, which is meant for quaternions of order 1, sees it.
  if (area > 0) rotation = rotation * (1 / area);
  vertex_tape_[vertex] = {normal, rotation};
  vertices_[vertex].normal = math::Normalize(normal);
  vertices_[vertex].rotation = math::Normalize(rotation);
  vertices_[vertex].area = end > begin ? area / float(end - begin) : 0;
}

// `d_sums`: dL/d of a vertex's normal sum, rotation sum (before its division by the area) and mean
// area divided by the number of faces.
Surface::FaceAdjoint Surface::FaceBackward(size_t face, const Buffer<SurfaceVertex>& d_sums) const {
  const Vec3<float>& area_vector = face_areas_[face].vector;
  Vec3<float> d_vector{0, 0, 0};
  Quat<float> d_rotation{0, 0, 0, 0};
  float d_area = 0;
  for (int c = 0; c < 3; ++c) {
    const SurfaceVertex& d = d_sums[faces_[face][c]];
    const float sign = signs_[vertex_face_of_corner_[3 * face + c]];
    d_vector += d.normal;
    d_rotation = d_rotation + d.rotation * (sign * face_areas_[face].size);
    d_area += d.area + sign * math::Dot(face_rotations_[face], d.rotation);
  }
  d_vector += math::LengthVjp(area_vector, d_area);
  FaceAdjoint out{};
  const auto p = Corners(face);
  auto& d = out.d_corner;
  math::AreaVectorVjp(p[0], p[1], p[2], d_vector, d[0], d[1], d[2]);
  math::FaceRotationVjp(p[0], p[1], p[2], canonical_frames_[face], d_rotation, d[0], d[1], d[2]);
  return out;
}

void Surface::Backward(const Buffer<SurfaceVertex>& d_surface,
                       std::vector<float>& d_vertices) const {
  Buffer<SurfaceVertex> d_sums(vertices_.size());
  ParallelFor(vertices_.size(), [&](size_t v) {
    const SurfaceVertex& d = d_surface[v];
    const int32_t count = topology_.vertex_face_begin[v + 1] - topology_.vertex_face_begin[v];
    const float area = vertices_[v].area * float(count);
    // Dividing the rotation sum by the area changes its norm only, which Normalize ignores: the
    // area may be taken as a constant there.
    const Quat<float> d_rotation = math::NormalizeVjp(vertex_tape_[v].rotation_sum, d.rotation);
    d_sums[v].position = d.position;
    d_sums[v].normal = math::NormalizeVjp(vertex_tape_[v].normal_sum, d.normal);
    d_sums[v].rotation = area > 0 ? d_rotation * (1 / area) : Quat<float>{0, 0, 0, 0};
    d_sums[v].area = count > 0 ? d.area / float(count) : 0;
  });
  std::vector<FaceAdjoint> adjoints(faces_.size());
  ParallelFor(faces_.size(), [&](size_t f) { adjoints[f] = FaceBackward(f, d_sums); });
  d_vertices.resize(3 * vertices_.size());
  ParallelFor(vertices_.size(), [&](size_t v) {
    Vec3<float> sum = d_sums[v].position;
    for (int32_t k = topology_.vertex_face_begin[v]; k < topology_.vertex_face_begin[v + 1]; ++k) {
      const int32_t f = topology_.vertex_faces[k];
      sum += adjoints[f].d_corner[CornerOf(faces_[f], v)];
    }
    d_vertices[3 * v] = sum.x;
    d_vertices[3 * v + 1] = sum.y;
    d_vertices[3 * v + 2] = sum.z;
  });
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
