#include "avatar/surface/surface.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "avatar/surface/kernels/surface.h"
#include "flame/model.h"
#include "splat/base/error.h"
#include "splat/device/buffer.h"
#include "splat/device/for_each.h"

namespace cosplat {
namespace {

using math::Vec3;

// The kernels read vertices as rows of floats.
static_assert(sizeof(SurfaceVertex) == kSurfaceVertexFloats * sizeof(float));

constexpr double kPublishedEnlargement = 4;

void CheckVertices(View<const float> vertices, size_t count) {
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

Surface::Surface(const CanonicalMesh& mesh, Stream& stream)
    : faces_(mesh.faces),
      topology_(BuildTopology("canonical mesh", mesh.faces, int(mesh.vertices.size() / 3))),
      stream_(&stream) {
  if (faces_.empty()) throw Error("canonical mesh", "faces", "there are none");
  cosplat::CheckVertices(mesh.vertices, mesh.vertices.size() / 3);
  UploadMesh(mesh);
  const size_t faces = faces_.size();
  vertices_.Refill(mesh.vertices.size() / 3, stream);
  posed_faces_.Refill(kPosedFaceFloats * (faces + 1), stream);
  posed_faces_.FillWithZeros(stream);  // the last row stays zero
  sums_.Refill(kVertexSumFloats * vertices_.size(), stream);
  signs_.Refill(topology_.vertex_faces.size(), stream);
  PoseCanonically(mesh);
}

void Surface::UploadMesh(const CanonicalMesh& mesh) {
  const size_t faces = faces_.size();
  std::vector<math::Mat3<float>> frames;
  const auto at = [&](int32_t v) {
    return Vec3<float>{mesh.vertices[3 * v], mesh.vertices[3 * v + 1], mesh.vertices[3 * v + 2]};
  };
  for (const auto& f : faces_) frames.push_back(math::FaceFrame(at(f[0]), at(f[1]), at(f[2])));
  std::vector<int32_t> corner_places(3 * faces);
  for (size_t v = 0; v + 1 < topology_.vertex_face_begin.size(); ++v)
    for (int32_t k = topology_.vertex_face_begin[v]; k < topology_.vertex_face_begin[v + 1]; ++k) {
      const size_t f = topology_.vertex_faces[k];
      corner_places[3 * f + CornerOf(faces_[f].data(), v)] = k;
    }
  const MeshTopology& t = topology_;
  face_vertices_.Upload(faces_.data()->data(), 3 * faces, *stream_);
  face_neighbors_.Upload(t.face_neighbors.data()->data(), 3 * faces, *stream_);
  neighbor_edges_.Upload(t.neighbor_edges.data()->data(), 3 * faces, *stream_);
  vertex_face_begin_.Upload(t.vertex_face_begin, *stream_);
  vertex_faces_.Upload(t.vertex_faces, *stream_);
  corner_places_.Upload(corner_places.data(), 3 * faces, *stream_);
  canonical_frames_.Upload(frames.data(), faces, *stream_);
  stream_->Wait();  // the uploads read local memory
}

// Computed on the host for every stream, so that walks and searches start from the same bits.
void Surface::PoseCanonically(const CanonicalMesh& mesh) {
  if (!stream_->on_host()) {
    const Surface host(mesh);
    canonical_.Upload(host.canonical_, *stream_);
    canonical_areas_.Upload(host.canonical_areas_, *stream_);
    stream_->Wait();
    return;
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
  arrays.faces = face_vertices_.data();
  arrays.vertex_face_begin = vertex_face_begin_.data();
  arrays.vertex_faces = vertex_faces_.data();
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
  arrays.faces = face_vertices_.data();
  arrays.face_neighbors = face_neighbors_.data();
  arrays.neighbor_edges = neighbor_edges_.data();
  arrays.vertex_face_begin = vertex_face_begin_.data();
  arrays.vertex_faces = vertex_faces_.data();
  arrays.vertices = &canonical_.data()->position.x;
  return arrays;
}

void Surface::CheckVertices(View<const float> vertices) const {
  cosplat::CheckVertices(vertices, vertices_.size());
}

void Surface::Pose(View<const float> vertices) {
  if (stream_->on_host()) CheckVertices(vertices);
  const SurfaceArrays arrays = Arrays();
  ForEach(vertices_.size(), *stream_, math::PutPositionsKernel{vertices.data, arrays.vertices});
  ForEachRow(faces_.size(), *stream_, PoseFacesKernel{arrays});
  ForEachRow(vertices_.size(), *stream_, PoseVerticesKernel{arrays});
}

void Surface::Backward(const Buffer<SurfaceVertex>& d_surface, Buffer<float>& d_vertices) {
  const SurfaceArrays arrays = Arrays();
  d_sums_.Refill(vertices_.size(), *stream_);
  d_corners_.Refill(9 * faces_.size(), *stream_);
  d_vertices.Refill(3 * vertices_.size(), *stream_);
  float* d_sums = &d_sums_.data()->position.x;
  ForEachRow(
      vertices_.size(), *stream_, VerticesVjpKernel{arrays, &d_surface.data()->position.x, d_sums});
  ForEachRow(faces_.size(), *stream_, FacesVjpKernel{arrays, d_sums, d_corners_.data()});
  ForEach(vertices_.size(),
          *stream_,
          math::SumCornersKernel{arrays, d_sums, d_corners_.data(), d_vertices.data()});
}

size_t Surface::allocated_bytes() const {
  return AllocatedBytes(face_vertices_, face_neighbors_, vertex_face_begin_, vertex_faces_) +
         AllocatedBytes(
             corner_places_, neighbor_edges_, canonical_frames_, canonical_, canonical_areas_) +
         AllocatedBytes(vertices_, posed_faces_, sums_, signs_, d_sums_, d_corners_);
}

double FaceArea(const CanonicalMesh& mesh, size_t face) {
  Vec3<double> p[3];
  for (int c = 0; c < 3; ++c) {
    const size_t vertex = size_t(mesh.faces[face][c]);
    if (vertex >= mesh.vertices.size() / 3)
      throw Error("canonical mesh",
                  "faces[" + std::to_string(face) + "]",
                  "refers to vertex " + std::to_string(mesh.faces[face][c]) +
                      ", but there are only " + std::to_string(mesh.vertices.size() / 3));
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
