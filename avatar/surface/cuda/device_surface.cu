#include "avatar/surface/cuda/device_surface.h"
#include "avatar/surface/cuda/run_kernel.cuh"
#include "avatar/surface/kernels/surface.h"

namespace cosplat::cuda {
namespace {

struct PutPositions {
  const float* positions;  // [V, 3]
  float* vertices;         // [V, kSurfaceVertexFloats]
  __device__ void operator()(size_t v) const {
    for (size_t k = 0; k < 3; ++k) vertices[kSurfaceVertexFloats * v + k] = positions[3 * v + k];
  }
};

}  // namespace

DeviceSurface::DeviceSurface(const Surface& surface, cudaStream_t stream) {
  const SurfaceArrays host = surface.Arrays();
  const size_t faces = host.face_count, vertices = host.vertex_count;
  const size_t corners = surface.topology().vertex_faces.size();
  faces_.Upload(host.faces, 3 * faces, stream);
  vertex_face_begin_.Upload(host.vertex_face_begin, vertices + 1, stream);
  vertex_faces_.Upload(host.vertex_faces, corners, stream);
  corner_places_.Upload(host.corner_places, 3 * faces, stream);
  canonical_frames_.Upload(host.canonical_frames, 9 * faces, stream);
  canonical_areas_.Upload(surface.canonical_areas().data(), 4 * faces, stream);
  vertices_.Refill(kSurfaceVertexFloats * vertices);
  posed_faces_.Refill(kPosedFaceFloats * (faces + 1));
  posed_faces_.FillWithZeros(stream);  // its last row stays so
  sums_.Refill(kVertexSumFloats * vertices);
  signs_.Refill(corners);
  arrays_ = {faces,
             vertices,
             faces_.data(),
             vertex_face_begin_.data(),
             vertex_faces_.data(),
             corner_places_.data(),
             canonical_frames_.data(),
             vertices_.data(),
             posed_faces_.data(),
             sums_.data(),
             signs_.data()};
}

void DeviceSurface::Pose(const float* vertices, cudaStream_t stream) {
  ForEach(vertex_count(), stream, PutPositions{vertices, vertices_.data()});
  ForEachRow(face_count(), stream, math::PoseFacesKernel{arrays_});
  ForEachRow(vertex_count(), stream, math::PoseVerticesKernel{arrays_});
}

void DeviceSurface::Backward(const float* d_surface,
                             DeviceBuffer<float>& d_vertices,
                             cudaStream_t stream) {
  d_sums_.Refill(kSurfaceVertexFloats * vertex_count());
  d_corners_.Refill(9 * face_count());
  d_vertices.Refill(3 * vertex_count());
  ForEachRow(vertex_count(), stream, math::VerticesVjpKernel{arrays_, d_surface, d_sums_.data()});
  ForEachRow(
      face_count(), stream, math::FacesVjpKernel{arrays_, d_sums_.data(), d_corners_.data()});
  ForEachIndex(
      vertex_count(),
      stream,
      math::SumCornersKernel{arrays_, d_sums_.data(), d_corners_.data(), d_vertices.data()});
}

size_t DeviceSurface::held() const {
  return HeldBy(faces_, vertex_face_begin_, vertex_faces_, corner_places_, canonical_frames_) +
         HeldBy(canonical_areas_, vertices_, posed_faces_, sums_, signs_, d_sums_, d_corners_);
}

}  // namespace cosplat::cuda
