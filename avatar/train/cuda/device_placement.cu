#include <algorithm>

#include "avatar/surface/kernels/place.h"
#include "avatar/train/cuda/device_placement.h"
#include "splat/device/cuda/gather_rows.cuh"

namespace cosplat::cuda {
namespace {

// Threads that search at a time, for each of which there are 12 kB: a round of density control on a
// head has some hundred children.
constexpr size_t kSearchers = 1024;

// Thread s takes every kSearchers-th child from the s-th on.
struct MoveEach {
  MeshArrays mesh;
  DeviceView<const float> offsets;
  size_t first;
  bool keeps_d;
  DeviceView<math::FaceSearch> searches;
  int32_t* triangle;
  float* barycentric;
  DeviceView<float> position;
  __device__ void operator()(size_t s) const {
    for (size_t c = s; 3 * c < offsets.count; c += searches.count) {
      const size_t i = first + c;
      math::MoveOnMesh(mesh,
                       {offsets[3 * c], offsets[3 * c + 1], offsets[3 * c + 2]},
                       keeps_d,
                       {triangle + i, barycentric + 2 * i, &position[3 * i]},
                       searches[s]);
    }
  }
};

struct PlaceEach {
  MeshArrays mesh;
  const int32_t* triangle;
  const float* barycentric;
  DeviceView<const float> position;
  DeviceView<float> centers;
  __device__ void operator()(size_t i) const {
    const math::Vec3<float> p =
        math::CanonicalPlace(mesh, triangle[i], barycentric + 2 * i, &position[3 * i]);
    centers[3 * i] = p.x;
    centers[3 * i + 1] = p.y;
    centers[3 * i + 2] = p.z;
  }
};

struct RateEach {
  DeviceView<const float> face_rates;
  const int32_t* triangle;
  DeviceView<float> rates;
  __device__ void operator()(size_t i) const {
    rates[3 * i] = rates[3 * i + 1] = face_rates[size_t(triangle[i])];
    rates[3 * i + 2] = 1;
  }
};

}  // namespace

DevicePlacement::DevicePlacement() { searches_.Refill(kSearchers); }

void DevicePlacement::Move(const DeviceMesh& mesh,
                           DeviceView<const float> offsets,
                           size_t first,
                           bool keeps_d,
                           DeviceEmbedding& embedding,
                           DeviceBuffer<float>& position,
                           cudaStream_t stream) {
  const DeviceEmbedding::Movable moved = embedding.Move();
  ForEach(std::min(searches_.size(), offsets.count / 3),
          stream,
          MoveEach{mesh.arrays(),
                   offsets,
                   first,
                   keeps_d,
                   searches_.view(),
                   moved.triangle,
                   moved.barycentric,
                   position.view()});
}

DeviceView<const float> DevicePlacement::Centers(const DeviceMesh& mesh,
                                                 const DeviceEmbedding& embedding,
                                                 const DeviceBuffer<float>& position,
                                                 cudaStream_t stream) {
  centers_.Refill(3 * embedding.size());
  ForEach(embedding.size(),
          stream,
          PlaceEach{mesh.arrays(),
                    embedding.triangle(),
                    embedding.barycentric(),
                    position.view(),
                    centers_.view()});
  return std::as_const(centers_).view();
}

void DevicePlacement::Rates(DeviceView<const float> face_rates,
                            const DeviceEmbedding& embedding,
                            DeviceBuffer<float>& rates,
                            cudaStream_t stream) {
  rates.Refill(3 * embedding.size());
  ForEach(embedding.size(), stream, RateEach{face_rates, embedding.triangle(), rates.view()});
}

void DevicePlacement::GatherTriangles(DeviceView<const uint32_t> source,
                                      DeviceBuffer<int32_t>& triangles,
                                      cudaStream_t stream) {
  GatherArray(triangles, spare_, 1, source, source.count, stream);
}

}  // namespace cosplat::cuda
