#include <bit>

#include "avatar/surface/cuda/device_binding.h"
#include "avatar/surface/cuda/run_kernel.cuh"
#include "avatar/surface/kernels/embed.h"
#include "splat/base/error.h"
#include "splat/device/cuda/find_begin.cuh"
#include "splat/device/cuda/gather_rows.cuh"

namespace cosplat::cuda {
namespace {

struct FaceKeys {
  const int32_t* triangle;
  DeviceView<uint32_t> keys, values;
  __device__ void operator()(size_t i) const {
    keys[i] = uint32_t(triangle[i]);
    values[i] = uint32_t(i);
  }
};

EmbedJob JobOf(const DeviceGaussians& gaussians,
               const DeviceEmbedding& embedding,
               const DeviceSurface& surface) {
  return {embedding.size(),
          embedding.triangle(),
          embedding.barycentric(),
          gaussians.values[kPosition].data(),
          gaussians.values[kRotation].data(),
          gaussians.values[kScaleLog].data(),
          surface.arrays().faces,
          surface.arrays().vertices,
          surface.canonical_areas()};
}

}  // namespace

void DevicePosed::Refill(size_t n) {
  position.Refill(3 * n);
  rotation.Refill(4 * n);
  scale_log.Refill(3 * n);
  frame.Refill(4 * n);
}

WorldGaussians DevicePosed::View(const DeviceGaussians& gaussians, ColorFrame color_frame) const {
  WorldGaussians view = gaussians.View();
  view.position = position.data();
  view.rotation = rotation.data();
  view.scale_log = scale_log.data();
  if (color_frame == ColorFrame::kSurface) view.color_frame = frame.data();
  return view;
}

void DeviceEmbedding::Upload(const Embedding& embedding, size_t face_count, cudaStream_t stream) {
  if (embedding.released)
    throw Error(
        "avatar",
        "mesh",
        "is followed by the rule of the released SplattingAvatar, which is the CPU's alone");
  const size_t n = embedding.triangle.size();
  face_count_ = face_count;
  listed_ = false;
  triangle_.Upload(embedding.triangle.data(), n, stream);
  barycentric_.Upload(n == 0 ? nullptr : embedding.barycentric.data()->data(), 2 * n, stream);
}

FaceListArrays DeviceEmbedding::Lists(cudaStream_t stream) {
  if (!listed_) {
    by_face_.Refill(size());
    begin_.Refill(face_count_ + 1);
    ForEach(
        size(), stream, FaceKeys{triangle_.data(), by_face_.keys.view(), by_face_.values.view()});
    sorter_.Sort(by_face_, std::bit_width(face_count_), stream);
    ForEach(face_count_ + 1, stream, FindBegin{std::as_const(by_face_.keys).view(), begin_.view()});
    listed_ = true;
  }
  return {begin_.data(), by_face_.values.data()};
}

void DeviceEmbedding::Gather(DeviceView<const uint32_t> source, cudaStream_t stream) {
  listed_ = false;
  GatherArray(triangle_, spare_triangle_, 1, source, source.count, stream);
  GatherArray(barycentric_, spare_barycentric_, 2, source, source.count, stream);
}

void DeviceEmbedding::Download(Embedding& to, cudaStream_t stream) const {
  to.triangle.resize(size());
  to.barycentric.resize(size());
  triangle_.Download(to.triangle.data(), stream);
  barycentric_.Download(size() == 0 ? nullptr : to.barycentric.data()->data(), stream);
}

std::vector<int32_t> DeviceEmbedding::Triangles(cudaStream_t stream) const {
  std::vector<int32_t> triangles(size());
  triangle_.Download(triangles.data(), stream);
  Check(cudaStreamSynchronize(stream), "cudaStreamSynchronize");
  return triangles;
}

size_t DeviceEmbedding::held() const {
  return HeldBy(triangle_, barycentric_, spare_triangle_, spare_barycentric_) + by_face_.held() +
         sorter_.held();
}

void DeviceBinding::Bind(const DeviceGaussians& gaussians,
                         const DeviceEmbedding& embedding,
                         const DeviceSurface& surface,
                         DevicePosed& out,
                         cudaStream_t stream) const {
  out.Refill(embedding.size());
  ForEachRow(
      embedding.size(),
      stream,
      math::EmbedKernel{
          JobOf(gaussians, embedding, surface),
          {out.position.data(), out.rotation.data(), out.scale_log.data(), out.frame.data()}});
}

void DeviceBinding::Backward(const DeviceGaussians& gaussians,
                             DeviceEmbedding& embedding,
                             DeviceSurface& surface,
                             const DevicePosed& d_posed,
                             DeviceGaussians& d_gaussians,
                             DeviceBuffer<float>* d_vertices,
                             cudaStream_t stream) {
  const size_t n = embedding.size();
  d_corners_.Refill(d_vertices ? 3 * kSurfaceVertexFloats * n : 0);
  ForEachRow(n,
             stream,
             math::EmbedVjpKernel{JobOf(gaussians, embedding, surface),
                                  {d_posed.position.data(),
                                   d_posed.rotation.data(),
                                   d_posed.scale_log.data(),
                                   d_posed.frame.empty() ? nullptr : d_posed.frame.data()},
                                  {d_gaussians.values[kPosition].data(),
                                   d_gaussians.values[kRotation].data(),
                                   d_gaussians.values[kScaleLog].data(),
                                   d_vertices ? d_corners_.data() : nullptr}});
  if (!d_vertices) return;
  d_surface_.Refill(kSurfaceVertexFloats * surface.vertex_count());
  ForEachIndex(
      surface.vertex_count(),
      stream,
      math::SumAtVertexKernel{
          surface.arrays(), embedding.Lists(stream), d_corners_.data(), d_surface_.data()});
  surface.Backward(d_surface_.data(), *d_vertices, stream);
}

}  // namespace cosplat::cuda
