#include "avatar/surface/cuda/device_walk.h"
#include "splat/device/cuda/launch.cuh"

namespace cosplat::cuda {
namespace {

struct WalkOne {
  MeshArrays mesh;
  const int32_t* triangle;
  const float* barycentric;
  DeviceView<const float> position;
  DeviceView<math::WalkEnd> ends;
  DeviceView<uint8_t> taken;
  DeviceView<uint64_t> touches;  // [N + 1] flags of walks from or to a face with a boundary edge
  __device__ void operator()(size_t i) const {
    touches[i] = 0;
    if (i == ends.count) return;
    const int32_t from = triangle[i];
    const math::WalkEnd end = math::WalkGaussian(mesh, from, barycentric + 2 * i, &position[3 * i]);
    ends[i] = end;
    taken[i] = end.status != WalkStatus::kInvalid;
    touches[i] = taken[i] && end.face != from &&
                 (math::HasBoundaryEdge(mesh, from) || math::HasBoundaryEdge(mesh, end.face));
  }
};

struct CountOnFace {
  const uint32_t* begin;  // [F + 1]
  DeviceView<int32_t> count;
  __device__ void operator()(size_t f) const { count[f] = int32_t(begin[f + 1] - begin[f]); }
};

struct ListTouching {
  DeviceView<const uint64_t> places;
  DeviceView<uint32_t> list;
  __device__ void operator()(size_t i) const {
    if (places[i + 1] != places[i]) list[places[i]] = uint32_t(i);
  }
};

// One thread.
struct TakeEach {
  math::WalkTaker taker;
  const int32_t* triangle;
  DeviceView<const uint32_t> list;
  const uint64_t* how_many;
  DeviceView<const math::WalkEnd> ends;
  DeviceView<uint8_t> taken;
  __device__ void operator()(size_t) const {
    for (size_t k = 0; k < *how_many; ++k) {
      const uint32_t i = list[k];
      taken[i] = taker.Take(triangle[i], ends[i].face);
    }
  }
};

struct Settle {
  DeviceView<const math::WalkEnd> ends;
  DeviceView<const uint8_t> taken;
  int32_t* triangle;
  float* barycentric;
  DeviceView<float> position;
  DeviceView<uint8_t> outcomes;
  __device__ void operator()(size_t i) const {
    const math::WalkEnd& end = ends[i];
    position[3 * i] = position[3 * i + 1] = 0;
    const bool invalid = end.status == WalkStatus::kInvalid;
    const bool stopped = end.status == WalkStatus::kBoundary || (!invalid && !taken[i]);
    const bool crossed = taken[i] && end.face != triangle[i];
    outcomes[i] =
        uint8_t((crossed ? DeviceWalk::kCrossed : 0) | (stopped ? DeviceWalk::kStopped : 0) |
                (invalid ? DeviceWalk::kInvalid : 0));
    if (!taken[i]) return;
    triangle[i] = end.face;
    barycentric[2 * i] = end.u;
    barycentric[2 * i + 1] = end.v;
  }
};

struct ForgetMoment {
  DeviceView<const uint8_t> outcomes;
  DeviceView<float> moment;
  __device__ void operator()(size_t i) const {
    if (outcomes[i]) moment[3 * i] = moment[3 * i + 1] = 0;
  }
};

}  // namespace

void DeviceWalk::Walk(const DeviceMesh& mesh,
                      int boundary_face_cap,
                      DeviceEmbedding& embedding,
                      DeviceBuffer<float>& position,
                      cudaStream_t stream) {
  const size_t n = embedding.size();
  ends_.Refill(n);
  taken_.Refill(n);
  outcomes_.Refill(n);
  places_.Refill(n + 1);
  ForEach(n + 1,
          stream,
          WalkOne{mesh.arrays(),
                  embedding.triangle(),
                  embedding.barycentric(),
                  std::as_const(position).view(),
                  ends_.view(),
                  taken_.view(),
                  places_.view()});
  TakeInTurn(mesh, boundary_face_cap, embedding, stream);
  const DeviceEmbedding::Movable moved = embedding.Move();
  ForEach(n,
          stream,
          Settle{std::as_const(ends_).view(),
                 std::as_const(taken_).view(),
                 moved.triangle,
                 moved.barycentric,
                 position.view(),
                 outcomes_.view()});
}

void DeviceWalk::TakeInTurn(const DeviceMesh& mesh,
                            int boundary_face_cap,
                            DeviceEmbedding& embedding,
                            cudaStream_t stream) {
  const size_t n = embedding.size(), faces = embedding.face_count();
  sorter_.ExclusiveSum(places_, stream);
  at_boundary_.Refill(n);
  ForEach(n, stream, ListTouching{std::as_const(places_).view(), at_boundary_.view()});
  face_count_.Refill(faces);
  ForEach(faces, stream, CountOnFace{embedding.Lists(stream).begin, face_count_.view()});
  ForEach(1,
          stream,
          TakeEach{{mesh.arrays(), boundary_face_cap, face_count_.data()},
                   embedding.triangle(),
                   std::as_const(at_boundary_).view(),
                   places_.data() + n,
                   std::as_const(ends_).view(),
                   taken_.view()});
}

void DeviceWalk::ResetMoment(DeviceBuffer<float>& moment, cudaStream_t stream) const {
  ForEach(outcomes_.size(), stream, ForgetMoment{outcomes_.view(), moment.view()});
}

size_t DeviceWalk::held() const {
  return HeldBy(ends_, taken_, outcomes_, places_, at_boundary_) + sorter_.held();
}

}  // namespace cosplat::cuda
