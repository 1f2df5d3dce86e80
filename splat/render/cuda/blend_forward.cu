#include "splat/render/cuda/blend.cuh"
#include "splat/render/cuda/tape.h"
#include "splat/render/kernels/tile_range.h"

namespace cosplat::cuda {
namespace {

// Blends the tile's instances front to back, one batch at a time in shared memory. Each warp first
// tests which of 32 splats reach its patch of pixels, one per lane, and then blends those.
struct ForwardKernel {
  static constexpr unsigned kThreads = kTilePixels;
  TileListsView lists;
  View<const ProjectedSplat> splats;
  int width, height;
  float background[3];
  View<float> color, transmittance;
  View<uint32_t> n_contrib;
  View<PixelCheckpoint> checkpoints;  // empty: not stored

  struct Shared {
    BlendSplat splats[kThreads];
    uint32_t n_contrib[kThreads / kWarp];
  };
  using State = math::BlendState<float>;

  __device__ void operator()() const {
    Shared& shared = SharedMemory<Shared>();
    const int tile = int(blockIdx.x);
    const TilePixels pixels(tile, lists.tiles_x);
    const int x = pixels.x(int(threadIdx.x)), y = pixels.y(int(threadIdx.x));
    const bool inside = x < width && y < height;
    State state{inside ? 1.0f : 0.0f, {0, 0, 0}};
    const uint32_t begin = lists.tile_begin[tile], count = lists.tile_begin[tile + 1] - begin;
    uint32_t looked = 0;  // instances processed before this warp's pixels were opaque
    for (uint32_t batch = 0; batch < count; batch += kThreads) {
      // The barrier also keeps the last batch in place until all threads have finished with it.
      if (__syncthreads_count(state.transmittance >= kMinTransmittance) == 0) break;
      const uint32_t k = batch + threadIdx.x;
      if (k < count) shared.splats[threadIdx.x] = BlendSplat(splats[lists.gaussian[begin + k]]);
      __syncthreads();
      const uint32_t end = math::Min(count - batch, uint32_t(kThreads));
      for (uint32_t chunk = 0; chunk < end; chunk += kBucket) {
        Keep(lists.bucket_begin[tile] + (batch + chunk) / kBucket, state);
        if (!__any_sync(kAllLanes, state.transmittance >= kMinTransmittance)) continue;
        const uint32_t n = math::Min(end - chunk, uint32_t(kBucket));
        looked = batch + chunk + n;
        BlendChunk(shared.splats + chunk, n, pixels, x, y, state);
      }
    }
    StoreContributors(tile, looked, shared);
    if (inside) StorePixel(size_t(y) * width + x, state);
  }

  __device__ void Keep(uint64_t bucket, const State& state) const {
    if (checkpoints.count == 0) return;
    checkpoints[bucket * kTilePixels + threadIdx.x] =
        make_float4(state.transmittance, state.color.x, state.color.y, state.color.z);
  }

  __device__ void BlendChunk(const BlendSplat* chunk,
                             uint32_t n,
                             const TilePixels& pixels,
                             int x,
                             int y,
                             State& state) const {
    const int first = int(WarpInBlock() * kWarp);  // the patch's first pixel
    const bool reaches =
        Lane() < n &&
        math::TouchesRectangle(
            chunk[Lane()], pixels.x(first), pixels.y(first), kPatchWidth, kPatchHeight);
    for (unsigned left = __ballot_sync(kAllLanes, reaches); left != 0; left &= left - 1) {
      const BlendSplat& s = chunk[__ffs(left) - 1];
      const float power = PowerAt(s.form(), x + 0.5f - s.x, y + 0.5f - s.y);
      if (math::Accepts(power, s.reject_below, state.transmittance))
        BlendBehind(math::AlphaOf(s.opacity, Falloff(power)), s.color(), state);
    }
  }

  __device__ void StoreContributors(int tile, uint32_t looked, Shared& shared) const {
    if (Lane() == 0) shared.n_contrib[WarpInBlock()] = looked;
    __syncthreads();
    if (threadIdx.x != 0) return;
    for (unsigned w = 1; w < kThreads / kWarp; ++w) looked = math::Max(looked, shared.n_contrib[w]);
    n_contrib[tile] = looked;
  }

  __device__ void StorePixel(size_t at, const State& state) const {
    const size_t plane = size_t(width) * height;
    const float t = state.transmittance;
    color[at] = state.color.x + t * background[0];
    color[plane + at] = state.color.y + t * background[1];
    color[2 * plane + at] = state.color.z + t * background[2];
    transmittance[at] = t;
  }
};

}  // namespace

void BlendForward(CudaTape& tape, RenderedImage& image, Stream& stream) {
  const size_t pixels = size_t(image.width) * image.height;
  image.color.Refill(3 * pixels, stream);
  image.transmittance.Refill(pixels, stream);
  tape.n_contrib.Refill(tape.lists.tiles(), stream);
  tape.checkpoints.Refill(tape.kept ? tape.lists.max_buckets() * kTilePixels : 0, stream);
  const std::array<float, 3>& b = tape.settings.background;
  ForBlocks(tape.lists.tiles(),
            stream,
            ForwardKernel{tape.lists.view(),
                          std::as_const(tape.splats).view(),
                          image.width,
                          image.height,
                          {b[0], b[1], b[2]},
                          image.color.view(),
                          image.transmittance.view(),
                          tape.n_contrib.view(),
                          tape.checkpoints.view()});
}

}  // namespace cosplat::cuda
