#include <cmath>

#include "splat/device/cuda/launch.cuh"
#include "splat/train/cuda/step_parts.h"

namespace cosplat::cuda {
namespace {

struct AccumulateStep {
  DeviceView<const float> radii, screen, d_scale_log, scale_log;
  int width, height;
  DeviceView<float> screen_gradient, plasticity, visible;
  const uint32_t* overflowed;
  __device__ void operator()(size_t i) const {
    if (!(radii[i] > 0) || *overflowed != 0) return;
    const math::ShapeOfStep step =
        math::ShapeOf(&screen[2 * i], &d_scale_log[3 * i], &scale_log[3 * i], width, height);
    if (!step.IsUsable()) return;
    screen_gradient[i] += step.screen;
    plasticity[i] += step.plasticity;
    visible[i] += 1;
  }
};

struct AddTo {
  DeviceView<const Contribution> more;
  DeviceView<Contribution> sums;
  __device__ void operator()(size_t i) const { sums[i] += more[i]; }
};

struct NeedleRule {
  float limit_log, ratio_log;
  // The axis of a needle's length; -1 for what is none.
  __device__ int AxisOf(const float* s) const {
    int longest = 0, shortest = 0;
    for (int k = 1; k < 3; ++k) {
      if (s[longest] < s[k]) longest = k;
      if (s[k] < s[shortest]) shortest = k;
    }
    return s[longest] <= limit_log || s[longest] - s[shortest] <= ratio_log ? -1 : longest;
  }
};

// The lengths of each block's needles, and how many; added up in order.
struct SumNeedles {
  static constexpr unsigned kThreads = 256;
  NeedleRule rule;
  DeviceView<const float> scale_log;  // [N, 3]
  size_t n;
  DeviceView<double> sums, counts;

  struct Shared {
    float length[kThreads];  // 0: none
  };
  __device__ void operator()() const {
    Shared& s = SharedMemory<Shared>();
    const size_t i = size_t(blockIdx.x) * kThreads + threadIdx.x;
    const float* scale = i < n ? &scale_log[3 * i] : nullptr;
    const int axis = scale ? rule.AxisOf(scale) : -1;
    s.length[threadIdx.x] = axis < 0 ? 0.0f : std::exp(scale[axis]);
    __syncthreads();
    if (threadIdx.x != 0) return;
    double sum = 0, count = 0;
    for (const float length : s.length) {
      sum += length;
      count += length > 0;
    }
    sums[blockIdx.x] = sum;
    counts[blockIdx.x] = count;
  }
};

struct AddUpNeedles {
  DeviceView<const double> sums, counts;
  float weight;
  NeedleTotal* total;
  __device__ void operator()(size_t) const {
    double sum = 0, count = 0;
    for (size_t b = 0; b < sums.count; ++b) {
      sum += sums[b];
      count += counts[b];
    }
    const double scale = count > 0 ? weight / count : 0;
    *total = {sum * scale, float(scale)};
  }
};

struct PullNeedles {
  NeedleRule rule;
  DeviceView<const float> scale_log, radii;
  const NeedleTotal* total;
  DeviceView<float> d_scale_log, moves;
  __device__ void operator()(size_t i) const {
    const float* s = &scale_log[3 * i];
    const int axis = rule.AxisOf(s);
    moves[i] = axis < 0 ? radii[i] : 1.0f;
    if (axis >= 0) d_scale_log[3 * i + axis] += total->scale * std::exp(s[axis]);
  }
};

}  // namespace

void Accumulate(DeviceView<const float> radii,
                DeviceView<const float> screen,
                int width,
                int height,
                Population& population,
                cudaStream_t stream) {
  Statistics& s = population.statistics;
  ForEach(population.size(),
          stream,
          AccumulateStep{radii,
                         screen,
                         std::as_const(population.gradients.values[kScaleLog]).view(),
                         std::as_const(population.values.values[kScaleLog]).view(),
                         width,
                         height,
                         s.screen_gradient.view(),
                         s.plasticity.view(),
                         s.visible.view(),
                         population.overflowed.data()});
}

void AddContributions(DeviceView<const Contribution> of_picture,
                      DeviceView<Contribution> sums,
                      cudaStream_t stream) {
  ForEach(sums.count, stream, AddTo{of_picture, sums});
}

void NeedleRegularizer::Add(const ScaleRegularizer& settings,
                            DeviceView<const float> radii,
                            Population& population,
                            cudaStream_t stream) {
  const size_t n = population.size();
  const size_t blocks = (n + SumNeedles::kThreads - 1) / SumNeedles::kThreads;
  const NeedleRule rule{std::log(settings.limit), std::log(settings.ratio)};
  const auto scale_log = std::as_const(population.values.values[kScaleLog]).view();
  sums_.Refill(blocks);
  counts_.Refill(blocks);
  total_.Refill(1);
  moves_.Refill(n);
  ForBlocks(blocks, stream, SumNeedles{rule, scale_log, n, sums_.view(), counts_.view()});
  ForEach(1,
          stream,
          AddUpNeedles{std::as_const(sums_).view(),
                       std::as_const(counts_).view(),
                       settings.weight,
                       total_.data()});
  ForEach(n,
          stream,
          PullNeedles{rule,
                      scale_log,
                      radii,
                      total_.data(),
                      population.gradients.values[kScaleLog].view(),
                      moves_.view()});
}

}  // namespace cosplat::cuda
