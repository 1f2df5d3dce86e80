#include "splat/math/photometric.h"
#include "splat/train/loss/cuda/ssim_tile.cuh"
#include "splat/train/loss/loss.h"

namespace cosplat::cuda {
namespace {

constexpr int kMoments = 4, kPartials = 3;

// Computes the sum of SSIM over the tile, and its derivatives with respect to the windowed means at
// every pixel.
struct SsimKernel {
  static constexpr unsigned kThreads = kLossThreads;
  ComparedImages images;
  SsimWeights window;
  float* partials;  // [channel, partial, height, width]
  double* sums;     // [blocks]

  struct Shared {
    HaloPlane u, v;
    AlongPlane along[kMoments];  // of u, v, u^2, v^2
    BlockSumScratch scratch;
  };

  __device__ void operator()() const {
    Shared& s = SharedMemory<Shared>();
    const LossTile tile(images.width, images.height);
    LoadSums(tile, s);
    __syncthreads();
    SumAlong(tile, s);
    __syncthreads();
    float ssim = 0;
    if (images.Contains(tile.x(), tile.y())) ssim = Compare(tile, s);
    const double sum = BlockSum(ssim, s.scratch);
    if (threadIdx.x == 0) sums[blockIdx.x] = sum;
  }

  __device__ void LoadSums(const LossTile& tile, Shared& s) const {
    const ComparedImages& in = images;
    tile.ForHalo([&](int r, int c, int x, int y) {
      const bool inside = in.Contains(x, y);
      const float image = inside ? in.rendered[in.At(tile.channel, x, y)] : 0;
      const float target = inside ? in.Target(tile.channel, x, y) : 0;
      s.u[r][c] = image + target;
      s.v[r][c] = image - target;
    });
  }

  __device__ void SumAlong(const LossTile& tile, Shared& s) const {
    const SsimWeights& w = window;
    tile.ForAlong([&](int r, int c) {
      const float *u = &s.u[r][c + math::kSsimRadius], *v = &s.v[r][c + math::kSsimRadius];
      s.along[0][r][c] = Weigh(w, u, 1);
      s.along[1][r][c] = Weigh(w, v, 1);
      s.along[2][r][c] = WeighSquares(w, u);
      s.along[3][r][c] = WeighSquares(w, v);
    });
  }

  // At the thread's pixel: writes the partials, returns SSIM.
  __device__ float Compare(const LossTile& tile, const Shared& s) const {
    float m[kMoments];
    for (int k = 0; k < kMoments; ++k)
      m[k] = Weigh(window, &s.along[k][tile.row() + math::kSsimRadius][tile.column()], kLossSide);
    const math::SsimMoments<float> moments{m[0], m[1], m[2], m[3]};
    const math::SsimPartials<float> d = SsimVjp(moments);
    const float values[kPartials] = {d.mean, d.uu, d.vv};
    for (int k = 0; k < kPartials; ++k)
      partials[images.At(kPartials * tile.channel + k, tile.x(), tile.y())] = values[k];
    return Ssim(moments);
  }
};

// Computes the gradient, and the sum of the pointwise terms over the tile. The window is symmetric,
// so the derivative of the windowed means is the same window over the partials.
template <bool kWithSsim>
struct GradientKernel {
  static constexpr unsigned kThreads = kLossThreads;
  ComparedImages images;
  SsimWeights window;
  const float* partials;
  float l1, mse, dssim;  // weights per value
  float* d_rendered;
  double* sums;  // [blocks]

  struct Shared {
    HaloPlane partials[kPartials];
    AlongPlane along[kPartials];
    BlockSumScratch scratch;
  };

  __device__ void operator()() const {
    Shared& s = SharedMemory<Shared>();
    const LossTile tile(images.width, images.height);
    if constexpr (kWithSsim) {
      LoadPartials(tile, s);
      __syncthreads();
      SumAlong(tile, s);
      __syncthreads();
    }
    float value = 0;
    if (images.Contains(tile.x(), tile.y())) value = StoreGradient(tile, s);
    const double sum = BlockSum(value, s.scratch);
    if (threadIdx.x == 0) sums[blockIdx.x] = sum;
  }

  __device__ void LoadPartials(const LossTile& tile, Shared& s) const {
    const ComparedImages& in = images;
    const float* from = partials;
    tile.ForHalo([&](int r, int c, int x, int y) {
      for (int k = 0; k < kPartials; ++k)
        s.partials[k][r][c] =
            in.Contains(x, y) ? from[in.At(kPartials * tile.channel + k, x, y)] : 0;
    });
  }

  __device__ void SumAlong(const LossTile& tile, Shared& s) const {
    const SsimWeights& w = window;
    tile.ForAlong([&](int r, int c) {
      for (int k = 0; k < kPartials; ++k)
        s.along[k][r][c] = Weigh(w, &s.partials[k][r][c + math::kSsimRadius], 1);
    });
  }

  // At the thread's pixel; returns its part of the pointwise sum.
  __device__ float StoreGradient(const LossTile& tile, const Shared& s) const {
    const size_t at = images.At(tile.channel, tile.x(), tile.y());
    const float image = images.rendered[at];
    const float target = images.Target(tile.channel, tile.x(), tile.y());
    const float u = image + target, v = image - target;
    float d = math::PointwiseVjp(l1, 2 * mse, v);
    if constexpr (kWithSsim) {
      float c[kPartials];
      for (int k = 0; k < kPartials; ++k)
        c[k] = Weigh(window, &s.along[k][tile.row() + math::kSsimRadius][tile.column()], kLossSide);
      d -= dssim * (c[0] + 2 * (u * c[1] + v * c[2]));
    }
    d_rendered[at] = d;
    return math::Pointwise(l1, mse, v);
  }
};

// One block sums the per-block results: each thread every 256th of them, then all by BlockSum.
struct AddUpLoss {
  static constexpr unsigned kThreads = kLossThreads;
  View<const double> pointwise, ssim;  // ssim: empty if its weight is 0
  double dssim, values;
  double* loss;

  struct Shared {
    BlockSumScratch pointwise, ssim;
  };

  __device__ void operator()() const {
    Shared& s = SharedMemory<Shared>();
    const double points = Sum(pointwise, s.pointwise), similar = Sum(ssim, s.ssim);
    if (threadIdx.x == 0) *loss = points + (ssim.count != 0 ? dssim * (1 - similar / values) : 0);
  }
  __device__ double Sum(const View<const double>& sums, BlockSumScratch& scratch) const {
    double sum = 0;
    for (size_t i = threadIdx.x; i < sums.count; i += kThreads) sum += sums[i];
    return BlockSum(sum, scratch);
  }
};

size_t LossBlocks(int width, int height) {
  const auto across = [](int px) { return size_t(px + kLossSide - 1) / kLossSide; };
  return 3 * across(width) * across(height);
}

class CudaLoss : public StepLoss {
 public:
  void Evaluate(const LossWeights& weights,
                View<const float> rendered,
                const TargetView& target,
                const std::array<float, 3>& background,
                Buffer<float>& d_rendered,
                Stream& stream) override;
  const double* value() const override { return value_.data(); }

 private:
  Buffer<float> partials_;    // [channel, partial, height, width]
  Buffer<double> ssim_sums_;  // [blocks]
  Buffer<double> pointwise_sums_;
  Buffer<double> value_;
};

void CudaLoss::Evaluate(const LossWeights& weights,
                        View<const float> rendered,
                        const TargetView& target,
                        const std::array<float, 3>& background,
                        Buffer<float>& d_rendered,
                        Stream& stream) {
  const size_t values = 3 * size_t(target.width) * target.height;
  const size_t blocks = LossBlocks(target.width, target.height);
  const bool with_ssim = weights.dssim != 0;
  d_rendered.Refill(values, stream);
  partials_.Refill(with_ssim ? kPartials * values : 0, stream);
  ssim_sums_.Refill(with_ssim ? blocks : 0, stream);
  pointwise_sums_.Refill(blocks, stream);
  value_.Refill(1, stream);
  const ComparedImages images{rendered.data,
                              target.bytes,
                              target.width,
                              target.height,
                              target.channels,
                              {background[0], background[1], background[2]}};
  SsimWeights window;
  math::SsimWindow(window.w);
  const float inv = 1.0f / float(values);
  const auto gradient = [&](auto kernel) {
    ForBlocks(blocks,
              stream,
              decltype(kernel){images,
                               window,
                               partials_.data(),
                               weights.l1 * inv,
                               weights.mse * inv,
                               weights.dssim * inv,
                               d_rendered.data(),
                               pointwise_sums_.data()});
  };
  if (with_ssim) {
    ForBlocks(blocks, stream, SsimKernel{images, window, partials_.data(), ssim_sums_.data()});
    gradient(GradientKernel<true>{});
  } else {
    gradient(GradientKernel<false>{});
  }
  ForBlocks(1,
            stream,
            AddUpLoss{std::as_const(pointwise_sums_).view(),
                      std::as_const(ssim_sums_).view(),
                      weights.dssim,
                      double(values),
                      value_.data()});
}

}  // namespace

std::unique_ptr<StepLoss> MakeCudaLoss() { return std::make_unique<CudaLoss>(); }

}  // namespace cosplat::cuda
