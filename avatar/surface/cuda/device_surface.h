// The posed surface on the device: avatar/surface/surface.h there, by the same bodies.
//
// posed vertices (of the host's FlamePoser) -> Pose -> device_binding.h; back: Backward ->
// dL/d(vertices), for the host. Every sum has one order: nothing differs from run to run.
#pragma once

#include "avatar/surface/kernels/arrays.h"
#include "avatar/surface/surface.h"
#include "splat/device/cuda/memory.h"
#include "splat/device/memory_part.h"

namespace cosplat::cuda {

class DeviceSurface {
 public:
  // Copies the mesh; no pose.
  DeviceSurface(const Surface& surface, cudaStream_t stream);

  // vertices: [V, 3], on the device; finite.
  void Pose(const float* vertices, cudaStream_t stream);
  // As Surface::Backward. d_surface: [V, kSurfaceVertexFloats], on the device.
  void Backward(const float* d_surface, DeviceBuffer<float>& d_vertices, cudaStream_t stream);

  size_t vertex_count() const { return arrays_.vertex_count; }
  size_t face_count() const { return arrays_.face_count; }
  // Pointers of the device.
  const SurfaceArrays& arrays() const { return arrays_; }
  const float* canonical_areas() const { return canonical_areas_.data(); }
  size_t held() const;  // bytes

 private:
  DeviceBuffer<int32_t> faces_, vertex_face_begin_, vertex_faces_, corner_places_;
  DeviceBuffer<float> canonical_frames_, canonical_areas_;
  DeviceBuffer<float> vertices_, posed_faces_, sums_, signs_;
  DeviceBuffer<float> d_sums_, d_corners_;
  SurfaceArrays arrays_;
};

}  // namespace cosplat::cuda
