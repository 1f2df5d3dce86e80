// Embedded Gaussians -> posed Gaussians and back on the device: avatar/surface/binding.h there, by
// the same bodies.
//
// DeviceGaussians, DeviceEmbedding + DeviceSurface (posed) -> Bind -> DevicePosed -> Renderer;
// back: BindBackward -> gradients of the embedded parameters and, if wanted, of the posed vertices.
// Every sum has one order.
#pragma once

#include "avatar/model/avatar_model.h"
#include "avatar/surface/cuda/device_surface.h"
#include "splat/device/cuda/sort.h"
#include "splat/render/cuda/device_gaussians.h"

namespace cosplat::cuda {

// PosedGaussians (avatar/surface/binding.h), or its gradients.
struct DevicePosed {
  DeviceBuffer<float> position, rotation, scale_log, frame;

  size_t size() const { return position.size() / 3; }
  void Refill(size_t n);
  size_t held() const { return HeldBy(position, rotation, scale_log, frame); }
  static constexpr size_t kBytesPerGaussian = (3 + 4 + 3 + 4) * sizeof(float);
  // `gaussians` with these numbers in place of its own.
  WorldGaussians View(const DeviceGaussians& gaussians, ColorFrame color_frame) const;
};

// Where on the mesh each Gaussian is.
class DeviceEmbedding {
 public:
  // Throws Error where it has the released rule (avatar/surface/released_binding.h), which the
  // device does not. The triangles must exist (CheckEmbedding, avatar/surface/binding.h).
  void Upload(const Embedding& embedding, size_t face_count, cudaStream_t stream);

  size_t size() const { return triangle_.size(); }
  size_t face_count() const { return face_count_; }
  const int32_t* triangle() const { return triangle_.data(); }
  const float* barycentric() const { return barycentric_.data(); }
  // Gaussians by face; sorted when first asked for after a change.
  FaceListArrays Lists(cudaStream_t stream);

  // For whoever moves Gaussians: both arrays change.
  struct Movable {
    int32_t* triangle;
    float* barycentric;
  };
  Movable Move() {
    listed_ = false;
    return {triangle_.data(), barycentric_.data()};
  }
  // Entry i becomes what source[i] was.
  void Gather(DeviceView<const uint32_t> source, cudaStream_t stream);
  // They are there when the stream has been waited for.
  void Download(Embedding& to, cudaStream_t stream) const;
  // The host waits.
  std::vector<int32_t> Triangles(cudaStream_t stream) const;
  // Bytes that grow with the Gaussians, and others.
  size_t held() const;
  size_t HeldForMesh() const { return HeldBy(begin_); }
  // Each Gaussian's: arrays and spares, keys and values in turn.
  static constexpr size_t kBytesPerGaussian =
      2 * (sizeof(int32_t) + 2 * sizeof(float)) + 4 * sizeof(uint32_t);

 private:
  size_t face_count_ = 0;
  bool listed_ = false;
  DeviceBuffer<int32_t> triangle_, spare_triangle_;
  DeviceBuffer<float> barycentric_, spare_barycentric_;  // [N, 2]
  KeyedValues by_face_;
  DeviceBuffer<uint32_t> begin_;
  Sorter sorter_;
};

// As Bind and BindBackward (avatar/surface/binding.h), with every array on the device.
class DeviceBinding {
 public:
  void Bind(const DeviceGaussians& gaussians,
            const DeviceEmbedding& embedding,
            const DeviceSurface& surface,
            DevicePosed& out,
            cudaStream_t stream) const;
  // An empty d_posed.frame counts as zero. d_vertices: [V, 3] overwritten, or null: then its cost
  // is saved.
  void Backward(const DeviceGaussians& gaussians,
                DeviceEmbedding& embedding,
                DeviceSurface& surface,
                const DevicePosed& d_posed,
                DeviceGaussians& d_gaussians,
                DeviceBuffer<float>* d_vertices,
                cudaStream_t stream);
  // Bytes that grow with the Gaussians, and others.
  size_t held() const { return HeldBy(d_corners_); }
  size_t HeldForMesh() const { return HeldBy(d_surface_); }
  // Each Gaussian's where there are d_vertices.
  static constexpr size_t kBytesPerCorners = 3 * kSurfaceVertexFloats * sizeof(float);

 private:
  DeviceBuffer<float> d_corners_;  // [N, 3, kSurfaceVertexFloats]; only for d_vertices
  DeviceBuffer<float> d_surface_;  // [V, kSurfaceVertexFloats]
};

}  // namespace cosplat::cuda
