#include "avatar/surface/kernels/holes.h"
#include "avatar/train/cuda/hole_guard.h"
#include "splat/device/cuda/launch.cuh"

namespace cosplat::cuda {
namespace {

// Of one face.
struct FindLast {
  FaceListArrays lists;
  DeviceView<const uint8_t> unwanted;
  DeviceView<uint8_t> last;
  uint32_t* any;
  __device__ void operator()(size_t f) const {
    const uint32_t begin = lists.begin[f], end = lists.begin[f + 1];
    bool none_left = true;
    for (uint32_t k = begin; k < end; ++k)
      if (!unwanted[lists.index[k]]) none_left = false;
    for (uint32_t k = begin; k < end; ++k) last[lists.index[k]] = none_left;
    if (none_left && begin != end) atomicAdd(any, 1u);
  }
};

struct ThinOut {
  DeviceView<const float> logits;
  DeviceView<const uint8_t> unwanted;
  DeviceView<float> thinned;
  __device__ void operator()(size_t i) const {
    thinned[i] = unwanted[i] ? math::kGoneLogit : logits[i];
  }
};

struct FindHoles {
  DeviceView<const uint8_t> silhouette;
  DeviceView<const float> before, after;
  DeviceView<uint8_t> holes;
  __device__ void operator()(size_t p) const {
    holes[p] = math::IsHole(silhouette[p] != 0, before[p], after[p]);
  }
};

struct SpareOne {
  math::HoleMask mask;
  DeviceView<const uint8_t> last;
  DeviceView<const float> radii;
  DeviceView<const ProjectedSplat> splats;
  DeviceView<uint8_t> unwanted;
  __device__ void operator()(size_t i) const {
    if (!last[i] || !unwanted[i] || !(radii[i] > 0)) return;
    if (mask.HasWithin(splats[i].x, splats[i].y, radii[i])) unwanted[i] = 0;
  }
};

}  // namespace

bool HoleGuard::Begin(const DeviceGaussians& gaussians,
                      DeviceEmbedding& embedding,
                      DeviceView<const uint8_t> unwanted,
                      cudaStream_t stream) {
  const size_t n = embedding.size();
  last_.Refill(n);
  any_.Refill(1);
  any_.FillWithZeros(stream);
  ForEach(embedding.face_count(),
          stream,
          FindLast{embedding.Lists(stream), unwanted, last_.view(), any_.data()});
  logits_.Refill(n);
  ForEach(n, stream, ThinOut{gaussians.values[kOpacityLogit].view(), unwanted, logits_.view()});
  return readback_.Get(any_.data(), stream) > 0;
}

void HoleGuard::Spare(const Canvas& canvas,
                      const WorldGaussians& world,
                      const Camera& camera,
                      const DeviceBuffer<uint8_t>& silhouette,
                      DeviceView<uint8_t> unwanted) {
  const cudaStream_t stream = canvas.renderer.stream().get();
  const RenderSettings black{{0, 0, 0}, 0};
  WorldGaussians thinned = world;
  thinned.opacity_logit = logits_.data();
  canvas.renderer.Forward(thinned, canvas.basis, camera, black, false, canvas.image, canvas.tape);
  after_.swap(canvas.image.transmittance);
  canvas.renderer.Forward(world, canvas.basis, camera, black, false, canvas.image, canvas.tape);
  holes_.Refill(silhouette.size());
  ForEach(silhouette.size(),
          stream,
          FindHoles{silhouette.view(),
                    std::as_const(canvas.image.transmittance).view(),
                    std::as_const(after_).view(),
                    holes_.view()});
  ForEach(world.count,
          stream,
          SpareOne{{holes_.data(), camera.width, camera.height},
                   std::as_const(last_).view(),
                   std::as_const(canvas.tape.radii).view(),
                   std::as_const(canvas.tape.splats).view(),
                   unwanted});
}

}  // namespace cosplat::cuda
