#include "splat/render/cuda/bucket_walk.cuh"
#include "splat/render/cuda/tape.h"

namespace cosplat::cuda {
namespace {

__device__ float FromLaneBefore(float x) { return __shfl_up_sync(kAllLanes, x, 1); }

__device__ math::Vec3<float> ColorAt(const float* planes, size_t plane, size_t at) {
  return {planes[at], planes[plane + at], planes[2 * plane + at]};
}

// The part of a pixel's colour that lies behind what the checkpoint has.
__device__ math::Vec3<float> ColorBehind(const BucketLists& in,
                                         size_t at,
                                         const PixelCheckpoint& before) {
  return ColorAt(in.color.data, in.Plane(), at) - math::Vec3<float>{before.y, before.z, before.w};
}

// Destination of an instance's gradient: added to its Gaussian directly, or stored in its record.
struct GradientSink {
  View<const uint32_t> record;
  View<SplatGradient> records;  // empty: atomics
  View<SplatGradient> d_splats;

  __device__ void Put(uint32_t k, uint32_t gaussian, const SplatGradient& d) const {
    if (records.count != 0) {
      records[record[k]] = d;
      return;
    }
    SplatGradient& sum = d_splats[gaussian];
    atomicAdd(&sum.x, d.x);
    atomicAdd(&sum.y, d.y);
    atomicAdd(&sum.power_xx, d.power_xx);
    atomicAdd(&sum.power_xy, d.power_xy);
    atomicAdd(&sum.power_yy, d.power_yy);
    atomicAdd(&sum.opacity, d.opacity);
    atomicAdd(&sum.r, d.r);
    atomicAdd(&sum.g, d.g);
    atomicAdd(&sum.b, d.b);
  }
};

struct BackwardWalk {
  const float* d_color;
  GradientSink sink;

  struct Pixel {
    math::Vec3<float> d;
  };
  struct alignas(8) State : math::BlendVjpState<float> {
    __device__ State FromLaneBefore() const {
      return {{cuda::FromLaneBefore(transmittance), cuda::FromLaneBefore(behind)}};
    }
  };
  struct Sum {
    math::PowerMoments<float> moments;
    math::Vec3<float> color;
  };

  __device__ Pixel PixelOf(const BucketLists& in, size_t at) const {
    return {ColorAt(d_color, in.Plane(), at)};
  }
  __device__ State StartOf(const BucketLists& in,
                           size_t at,
                           const PixelCheckpoint& before,
                           const Pixel& pixel) const {
    return {{before.x, Dot(pixel.d, ColorBehind(in, at, before))}};
  }
  __device__ void Step(const Pixel& pixel,
                       const BlendSplat& s,
                       float dx,
                       float dy,
                       float falloff,
                       State& state,
                       Sum& sum) const {
    const math::BlendVjpResult<float> d =
        BlendBehindVjp(math::AlphaOf(s.opacity, falloff), s.color(), pixel.d, state);
    sum.color += pixel.d * d.weight;
    Accumulate(math::AlphaOfVjp(s.opacity, falloff, d.d_alpha) * falloff, dx, dy, sum.moments);
  }
  __device__ void Finish(uint32_t k, uint32_t gaussian, const BlendSplat& s, const Sum& sum) const {
    const math::ShapeGradient<float> d = ShapeVjp(s.form(), s.opacity, sum.moments);
    sink.Put(k,
             gaussian,
             {d.x,
              d.y,
              d.power_xx,
              d.power_xy,
              d.power_yy,
              d.opacity,
              sum.color.x,
              sum.color.y,
              sum.color.z});
  }
};

struct ContributionWalk {
  View<const uint32_t> record;
  View<Contribution> records;

  struct Pixel {};
  struct alignas(16) State {
    float transmittance;
    math::Vec3<float> behind;
    __device__ State FromLaneBefore() const {
      return {cuda::FromLaneBefore(transmittance),
              {cuda::FromLaneBefore(behind.x),
               cuda::FromLaneBefore(behind.y),
               cuda::FromLaneBefore(behind.z)}};
    }
  };
  using Sum = math::PixelContribution<float>;

  __device__ Pixel PixelOf(const BucketLists&, size_t) const { return {}; }
  __device__ State StartOf(const BucketLists& in,
                           size_t at,
                           const PixelCheckpoint& before,
                           const Pixel&) const {
    return {before.x, ColorBehind(in, at, before)};
  }
  __device__ void Step(const Pixel&,
                       const BlendSplat& s,
                       float,
                       float,
                       float falloff,
                       State& state,
                       Sum& sum) const {
    const Sum c = math::ContributionBehind(
        true, s.opacity, falloff, s.color(), state.behind, state.transmittance);
    sum.weight += c.weight;
    sum.hits += c.hits;
    sum.sensitivity += c.sensitivity;
    sum.change += c.change;
  }
  __device__ void Finish(uint32_t k, uint32_t, const BlendSplat& s, const Sum& sum) const {
    records[record[k]] = {sum.weight, s.opacity * sum.hits, sum.sensitivity, sum.change};
  }
};

// Zero for the records that belong to no tile (EmitInstances) or to no instance, which no bucket
// writes.
template <class Record>
struct ClearUnlisted {
  TileListsView lists;
  View<Record> records;
  __device__ void operator()(size_t k) const {
    if (k >= lists.tile_begin[lists.tile_begin.count - 1]) records[lists.record[k]] = Record{};
  }
};

// Sums each Gaussian's records over its instances in a fixed order; 0 for invisible Gaussians.
template <class Record>
struct SumRecords {
  TileListsView lists;
  View<const Record> records;
  View<Record> sums;
  __device__ void operator()(size_t k) const {
    Record sum{};
    const uint64_t begin = lists.record_begin[k];
    const uint64_t end = lists.Complete() ? lists.record_begin[k + 1] : begin;
    for (uint64_t r = begin; r < end; ++r) sum += records[r];
    sums[lists.order[k]] = sum;
  }
};

}  // namespace

BucketLists BucketListsOf(const CudaTape& tape, const RenderedImage& image) {
  return {tape.lists.view(),
          tape.splats.view(),
          tape.n_contrib.view(),
          tape.checkpoints.view(),
          image.color.view(),
          image.width,
          image.height};
}

void BlendBackward(CudaTape& tape,
                   const RenderedImage& image,
                   const float* d_color,
                   Stream& stream) {
  const TileListsView lists = tape.lists.view();
  const bool fixed = tape.order == SumOrder::kFixed;
  tape.records.Refill(fixed ? tape.lists.capacity() : 0, stream);
  tape.d_splats.Refill(tape.splats.size(), stream);
  if (!fixed) tape.d_splats.FillWithZeros(stream);
  const GradientSink sink{lists.record, tape.records.view(), tape.d_splats.view()};
  WalkBuckets(tape, image, BackwardWalk{d_color, sink}, stream);
  if (!fixed) return;
  ForEachThread(
      tape.records.size(), stream, ClearUnlisted<SplatGradient>{lists, tape.records.view()});
  ForEachThread(
      tape.splats.size(),
      stream,
      SumRecords<SplatGradient>{lists, std::as_const(tape.records).view(), tape.d_splats.view()});
}

void SumContributions(CudaTape& tape,
                      const RenderedImage& image,
                      Contribution* contributions,
                      Stream& stream) {
  const TileListsView lists = tape.lists.view();
  const size_t count = tape.splats.size();
  tape.contributions.Refill(tape.lists.capacity(), stream);
  WalkBuckets(tape, image, ContributionWalk{lists.record, tape.contributions.view()}, stream);
  ForEachThread(tape.contributions.size(),
                stream,
                ClearUnlisted<Contribution>{lists, tape.contributions.view()});
  ForEachThread(count,
                stream,
                SumRecords<Contribution>{
                    lists, std::as_const(tape.contributions).view(), {contributions, count}});
}

}  // namespace cosplat::cuda
