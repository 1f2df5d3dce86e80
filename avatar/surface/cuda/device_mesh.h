// The canonical mesh on the device, for what walks and searches over it (avatar/surface/kernels/).
// It goes up once.
#pragma once

#include "avatar/surface/kernels/arrays.h"
#include "avatar/surface/surface.h"
#include "splat/device/cuda/memory.h"

namespace cosplat::cuda {

class DeviceMesh {
 public:
  DeviceMesh(const Surface& surface, cudaStream_t stream);

  // Pointers of the device.
  const MeshArrays& arrays() const { return arrays_; }
  size_t held() const;  // bytes

 private:
  DeviceBuffer<int32_t> faces_, face_neighbors_, vertex_face_begin_, vertex_faces_;
  DeviceBuffer<int8_t> neighbor_edges_;
  DeviceBuffer<float> vertices_;
  MeshArrays arrays_;
};

}  // namespace cosplat::cuda
